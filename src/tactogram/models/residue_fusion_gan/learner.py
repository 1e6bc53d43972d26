"""Networks and training of a Residue-Fusion GAN as in Neshov et al. 2026, Sec. 2; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.evaluation.pictures.distances import picture_choice
from tactogram.model import Example, SignalKind, Stage
from tactogram.models.residue_fusion_gan.config import Config
from tactogram.nn.adversarial_networks import feature_matching_loss, gradient_penalty
from tactogram.nn.initial_weights import bare, normal_
from tactogram.nn.label_predictor import PredictorTraining
from tactogram.nn.patch_discriminator import PatchDiscriminator
from tactogram.nn.trunks import OMITTED, PerceptualLoss
from tactogram.nn.unet import UNet
from tactogram.signal import Image
from tactogram.training.picture_learner import VARIATION, PictureLearner


class ResidueFusion(nn.Module):
    """Addition of two convolutions of the generator's narrowest features and a classifier's maps to these features.

    ``width`` are the channels of the generator's features, ``features`` those of the classifier's maps.
    """

    def __init__(self, width: int, features: int) -> None:
        super().__init__()
        self.narrow = nn.Conv2d(features, width, 1)
        self.fuse = nn.Conv2d(2 * width, width, 3, padding=1)
        self.residue = nn.Conv2d(width, width, 3, padding=1)

    def forward(self, x: Tensor, maps: Tensor) -> Tensor:
        """Return features of the shape of ``x``, (batch, width, row, column); ``maps`` may have any size."""
        maps = F.adaptive_avg_pool2d(self.narrow(maps), (x.shape[-2], x.shape[-1]))  # B, W, R, C
        residue = self.residue(F.relu(self.fuse(torch.cat((x, maps), 1))))  # B, W, R, C
        fused: Tensor = x + residue
        return fused


def generator(config: Config, features: int) -> UNet:
    """Return the U-Net with the fusion at its bottleneck; ``features`` are the channels of the classifier's maps."""
    width = config.widths[-1]
    network = UNet(into=1, out=1, widths=config.widths, bottleneck=ResidueFusion(width, features))
    normal_(network, config.gain)
    return network


def discriminator(config: Config) -> PatchDiscriminator:
    """Return the critic: one PatchGAN without batch normalisation, which would couple the penalties of a batch."""
    network = PatchDiscriminator(into=2, layers=config.layers, width=config.width, norm="instance")
    normal_(network, config.gain)
    return network


class ResidueFusionLearner(PictureLearner[Config]):
    """U-Net with a classifier's feature maps fused in, against one Wasserstein critic."""

    variation = VARIATION
    choice = staticmethod(picture_choice)
    predictor: PredictorTraining
    perceptual: PerceptualLoss | None = None

    def __init__(
        self, config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
    ) -> None:
        super().__init__(config, kind, seed=seed, device=device, predictor=config.predictor)

    def networks(self) -> tuple[UNet, PatchDiscriminator]:
        return generator(self.config, self.predictor.bare.trunk.features), discriminator(self.config)

    @property
    def pairs_per_step(self) -> int:
        return self.config.batch_size * self.config.critic_updates

    @property
    def omitted(self) -> str:
        return "" if self.config.vgg_weights else OMITTED

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        if self.config.vgg_weights and self.perceptual is None:  # only a training needs the file
            self.perceptual = PerceptualLoss(self.config.vgg_weights).to(self.gan.device)
        return super().stages(examples)

    def update(self, photo: Tensor, picture: Tensor, label: Tensor, crops: Tensor) -> dict[str, float]:
        """Gulrajani et al. 2017, Algorithm 1, with feature matching and, if configured, a perceptual loss."""
        figures: dict[str, Tensor] = {}
        size = self.share.size(self.config.batch_size)
        for begin in range(0, len(photo), size):
            part = slice(begin, begin + size)
            figures |= self._update_critic(photo[part], picture[part])
        figures |= self._update_generator(photo[:size], picture[:size])
        return {name: value.item() for name, value in figures.items()}

    def _update_critic(self, photo: Tensor, picture: Tensor) -> dict[str, Tensor]:
        with torch.no_grad():
            fakes = self.gan.generator(photo, *self.conditioning(photo))
        real = self.gan.discriminator(torch.cat((photo, picture), 1))[-1].mean()
        fake = self.gan.discriminator(torch.cat((photo, fakes), 1))[-1].mean()
        with self.gan.autocast():  # Fabric's wrapper allows no gradient but by its own backward
            critic = bare(self.gan.discriminator)
            penalty = gradient_penalty(
                lambda x: critic(torch.cat((photo, x), 1))[-1].float().mean((1, 2, 3)), picture, fakes.float()
            )
        self.gan.descend(1, fake - real + self.config.penalty * penalty)
        return {"wasserstein": real - fake, "penalty": penalty}

    def _update_generator(self, photo: Tensor, picture: Tensor) -> dict[str, Tensor]:
        generated = self.gan.generator(photo, *self.conditioning(photo))  # B, 1, R, C
        with self.gan.fixed_discriminator():
            with torch.no_grad():
                real = self.gan.discriminator(torch.cat((photo, picture), 1))
            outputs = self.gan.discriminator(torch.cat((photo, generated), 1))
            figures = {
                "adversarial": -outputs[-1].mean(),
                "matching": feature_matching_loss([outputs], [real]),
            }
        loss = figures["adversarial"] + self.config.feature_matching * figures["matching"]
        if self.perceptual:
            figures["perceptual"] = self.perceptual.to(generated.device)(generated, picture)
            loss = loss + self.config.perceptual * figures["perceptual"]
        self.gan.descend(0, loss)
        return figures

    @torch.no_grad()
    def conditioning(self, photo: Tensor) -> tuple[Tensor]:
        """Return the classifier's feature maps, shape (batch, feature, row, column); it is no longer trained."""
        network = self.predictor.bare.eval()
        return (network.trunk.maps(photo.to(self.gan.device)),)

    def classify_photograph(self, image: Image) -> tuple[str, float]:
        return self._classified(image)


build = ResidueFusionLearner
