"""Generator and discriminators of Neshov et al. 2026, Tables 1 and 2."""

from __future__ import annotations

from torch import nn

from tactogram.models.visual_tactile_gan.config import Config
from tactogram.nn.initial_weights import normal_
from tactogram.nn.label_layers import ConditionalBatchNorm
from tactogram.nn.patch_discriminator import MultiScaleDiscriminator
from tactogram.nn.unet import UNet


def generator(config: Config, labels: int) -> UNet:
    """Return the U-Net: (batch, 1, 256, 256) down to (batch, 512, 1, 1) and back up; ``labels`` is the paper's C."""
    bottleneck = None
    if config.conditional:
        bottleneck = ConditionalBatchNorm(config.widths[-1], labels, gain=config.label_gain)
    network = UNet(into=1, out=1, widths=config.widths, bottleneck=bottleneck)
    normal_(network, config.gain)
    return network


def discriminator(config: Config) -> nn.Module:
    """Return the PatchGANs, each at half the resolution of the last, of photograph and picture as channels."""
    network = MultiScaleDiscriminator(
        count=config.discriminators, into=2, layers=config.layers, width=config.width
    )
    normal_(network, config.gain)
    return network
