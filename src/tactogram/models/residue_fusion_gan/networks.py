"""Generator and critic of a Residue-Fusion GAN, as described, and by our choice where nothing is."""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.residue_fusion_gan.config import Config
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import PatchDiscriminator
from tactogram.nn.unet import UNet


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
