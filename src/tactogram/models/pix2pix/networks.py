"""Generator and discriminator of Isola et al. 2017, Sec. 6.1."""

from __future__ import annotations

from tactogram.models.pix2pix.config import Config
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import PatchDiscriminator
from tactogram.nn.unet import UNet


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
