"""Generator and discriminator of Isola et al. 2017, Sec. 6.1."""

from __future__ import annotations

from torch import Tensor, nn

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


class MaskedUNet(nn.Module):
    """The U-Net with the factors of its dropout as further inputs."""

    def __init__(self, network: UNet) -> None:
        super().__init__()
        self.network = network

    def forward(self, photo: Tensor, *masks: Tensor) -> Tensor:
        """Return pictures, (batch, 1, row, column)."""
        made: Tensor = self.network(photo, masks=masks)
        return made


def discriminator(config: Config) -> PatchDiscriminator:
    """Return the PatchGAN: photograph and picture, (batch, 2, 256, 256), to scores (batch, 1, 30, 30)."""
    network = PatchDiscriminator(into=2, layers=config.layers, width=config.width, padding=1, bias=False)
    normal_(network, config.gain)
    return network
