"""Training of pix2pixHD's global generator as in Wang et al. 2018, Sec. 3; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from tactogram.evaluation.pictures.checkpoint_choice import picture_choice
from tactogram.model import Example, Stage
from tactogram.models.pix2pixhd.config import Config
from tactogram.models.pix2pixhd.networks import GlobalGenerator, discriminator, generator
from tactogram.nn.adversarial_loss import adversarial_loss, feature_matching_loss
from tactogram.nn.patch_discriminator import MultiScaleDiscriminator, scores
from tactogram.nn.perceptual_loss import OMITTED, PerceptualLoss
from tactogram.training.picture_learner import VARIATION, PictureLearner


class Pix2PixHDLearner(PictureLearner[Config]):
    """Residual generator and discriminators at several scales, by least squares and feature matching."""

    variation = VARIATION
    choice = staticmethod(picture_choice)
    perceptual: PerceptualLoss | None = None

    def networks(self) -> tuple[GlobalGenerator, MultiScaleDiscriminator]:
        return generator(self.config), discriminator(self.config)

    @property
    def omitted(self) -> str:
        return "" if self.config.vgg_weights else OMITTED

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        if self.config.vgg_weights and self.perceptual is None:  # only a training needs the file
            self.perceptual = PerceptualLoss(self.config.vgg_weights).to(self.gan.device)
        return super().stages(examples)

    def update(self, photo: Tensor, picture: Tensor, label: Tensor, crops: Tensor) -> dict[str, float]:
        """Update both networks by losses of the weights before either update, as the authors' code does."""
        made = self.gan.generator(photo)  # B, 1, R, C
        real = self.gan.discriminator(torch.cat((photo, picture), 1))
        fake = self.gan.discriminator(torch.cat((photo, made.detach()), 1))
        kind = self.config.adversarial
        loss_d = adversarial_loss(scores(real), real=True, kind=kind)
        loss_d = (loss_d + adversarial_loss(scores(fake), real=False, kind=kind)) / 2
        with self.gan.fixed_discriminator():
            outputs = self.gan.discriminator(torch.cat((photo, made), 1))
            adversarial = adversarial_loss(scores(outputs), real=True, kind=kind)
            # The authors' code sums over a discriminator's layers with weights 4 / (L + 1).
            matching = 4 * feature_matching_loss(outputs, real)
        loss_g = adversarial + self.config.feature_matching * matching
        figures = {"discriminator": loss_d, "adversarial": adversarial, "matching": matching}
        if self.perceptual:
            figures["perceptual"] = self.perceptual.to(made.device)(made, picture)
            loss_g = loss_g + self.config.perceptual * figures["perceptual"]
        self.gan.descend(0, loss_g)
        self.gan.descend(1, loss_d)
        return {name: value.item() for name, value in figures.items()}


build = Pix2PixHDLearner
