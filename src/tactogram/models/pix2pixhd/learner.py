"""pix2pixHD's global generator and its training as in Wang et al. 2018, Sec. 3; from a photograph to a signal."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.distances import picture_choice
from tactogram.model import Example, Stage
from tactogram.models.pix2pixhd.config import Config
from tactogram.nn.adversarial_networks import adversarial_loss, feature_matching_loss
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import MultiScaleDiscriminator, scores
from tactogram.nn.trunks import OMITTED, PerceptualLoss
from tactogram.training.picture_learner import VARIATION, PictureLearner


class GlobalGenerator(nn.Module):
    """Convolution, ``downsamplings`` of stride 2, residual blocks, and back; instance normalisation throughout."""

    def __init__(self, config: Config) -> None:
        super().__init__()
        width, self.scale = config.generator_width, 2**config.downsamplings
        layers: list[nn.Module] = [nn.ReflectionPad2d(3), nn.Conv2d(1, width, 7), *_normalised(width)]
        for _ in range(config.downsamplings):
            layers += [nn.Conv2d(width, 2 * width, 3, stride=2, padding=1), *_normalised(2 * width)]
            width *= 2
        layers += [ResidualBlock(width) for _ in range(config.blocks)]
        for _ in range(config.downsamplings):
            layers.append(nn.ConvTranspose2d(width, width // 2, 3, stride=2, padding=1, output_padding=1))
            layers += _normalised(width // 2)
            width //= 2
        self.layers = nn.Sequential(*layers, nn.ReflectionPad2d(3), nn.Conv2d(width, 1, 7), nn.Tanh())

    def check_size(self, rows: int, columns: int) -> None:
        """Refuse pictures that cannot be halved at every stage, or leave less than two rows for residual blocks."""
        if rows % self.scale or columns % self.scale or min(rows, columns) < 2 * self.scale:
            raise ParameterError(
                f"rows and columns must be multiples of {self.scale}, two at least, got {(rows, columns)}"
            )

    def forward(self, photo: Tensor) -> Tensor:
        """Return pictures, (batch, 1, row, column) in -1 to 1, of photographs of that shape."""
        self.check_size(photo.shape[-2], photo.shape[-1])
        picture: Tensor = self.layers(photo)
        return picture


class ResidualBlock(nn.Module):
    """Two convolutions of 3 x 3, added to the identity."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.layers = nn.Sequential(
            nn.ReflectionPad2d(1), nn.Conv2d(width, width, 3), *_normalised(width),
            nn.ReflectionPad2d(1), nn.Conv2d(width, width, 3), nn.InstanceNorm2d(width),
        )  # fmt: skip

    def forward(self, x: Tensor) -> Tensor:
        added: Tensor = x + self.layers(x)
        return added


def generator(config: Config) -> GlobalGenerator:
    """Return the global generator: (batch, 1, 256, 256) to (batch, 1024, 16, 16) and back."""
    network = GlobalGenerator(config)
    normal_(network, config.gain)
    return network


def discriminator(config: Config) -> MultiScaleDiscriminator:
    """Return the PatchGANs, each at half the resolution of the last."""
    network = MultiScaleDiscriminator(
        count=config.discriminators, into=2, layers=config.layers, width=config.width, norm="instance"
    )
    normal_(network, config.gain)
    return network


def _normalised(width: int) -> list[nn.Module]:
    return [nn.InstanceNorm2d(width), nn.ReLU()]


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
        generated = self.gan.generator(photo)  # B, 1, R, C
        real = self.gan.discriminator(torch.cat((photo, picture), 1))
        fake = self.gan.discriminator(torch.cat((photo, generated.detach()), 1))
        kind = self.config.adversarial
        loss_d = adversarial_loss(scores(real), real=True, kind=kind)
        loss_d = (loss_d + adversarial_loss(scores(fake), real=False, kind=kind)) / 2
        with self.gan.fixed_discriminator():
            outputs = self.gan.discriminator(torch.cat((photo, generated), 1))
            adversarial = adversarial_loss(scores(outputs), real=True, kind=kind)
            # The authors' code sums over a discriminator's layers with weights 4 / (L + 1).
            matching = 4 * feature_matching_loss(outputs, real)
        loss_g = adversarial + self.config.feature_matching * matching
        figures = {"discriminator": loss_d, "adversarial": adversarial, "matching": matching}
        if self.perceptual:
            figures["perceptual"] = self.perceptual.to(generated.device)(generated, picture)
            loss_g = loss_g + self.config.perceptual * figures["perceptual"]
        self.gan.descend(0, loss_g)
        self.gan.descend(1, loss_d)
        return {name: value.item() for name, value in figures.items()}


build = Pix2PixHDLearner
