"""Networks (Sec. 6.1) and training (Sec. 3) of pix2pix, Isola et al. 2017; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor

from tactogram.evaluation.pictures.distances import picture_choice
from tactogram.model import Condition, Example
from tactogram.models.pix2pix.config import Config
from tactogram.nn.adversarial_networks import adversarial_loss
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import PatchDiscriminator
from tactogram.nn.unet import UNet
from tactogram.signal import Signal
from tactogram.training.picture_learner import PictureLearner
from tactogram.training.seeds import torch_seeded


def generator(config: Config) -> UNet:
    """Return the U-Net: (batch, 1, 256, 256) down to (batch, 512, 1, 1) and back up; its noise is dropout."""
    network = UNet(into=1, out=1, widths=config.widths, dropout=config.dropout)
    network.noise = True  # Sec. 3.3: "we apply dropout at test time"
    normal_(network, config.gain)
    return network


def discriminator(config: Config) -> PatchDiscriminator:
    """Return the PatchGAN: photograph and picture, (batch, 2, 256, 256), to scores (batch, 1, 30, 30)."""
    network = PatchDiscriminator(into=2, layers=config.layers, width=config.width, padding=1, bias=False)
    normal_(network, config.gain)
    return network


class Pix2PixLearner(PictureLearner[Config]):
    """U-Net and PatchGAN; dropout, in training and in use, is the generator's only noise."""

    choice = staticmethod(picture_choice)

    def networks(self) -> tuple[UNet, PatchDiscriminator]:
        return generator(self.config), discriminator(self.config)

    def update(self, photo: Tensor, picture: Tensor, label: Tensor, crops: Tensor) -> dict[str, float]:
        """Update the discriminator, its objective divided by 2, then the generator against it (Sec. 3.3)."""
        generated = self.gan.generator(photo)  # B, 1, R, C
        real = self.gan.discriminator(torch.cat((photo, picture), 1))[-1:]
        fake = self.gan.discriminator(torch.cat((photo, generated.detach()), 1))[-1:]
        loss_d = (adversarial_loss(real, real=True) + adversarial_loss(fake, real=False)) / 2
        self.gan.descend(1, loss_d)
        with self.gan.fixed_discriminator():
            outputs = self.gan.discriminator(torch.cat((photo, generated), 1))[-1:]
            adversarial, l1 = adversarial_loss(outputs, real=True), F.l1_loss(generated, picture)
        self.gan.descend(0, adversarial + self.config.l1 * l1)
        return {"discriminator": loss_d.item(), "adversarial": adversarial.item(), "l1": l1.item()}

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        with torch_seeded(0, "validate"):
            return super().validate(examples)

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        with torch_seeded(seed, "dropout"):
            return super().generate(condition, seconds=seconds, seed=seed)


build = Pix2PixLearner
