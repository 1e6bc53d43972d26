"""Generator, conditional batch norm and discriminators of Neshov et al. 2026, Tables 1 and 2.

References
----------
- De Vries, H. et al. (2017). Modulating early visual processing by language. NeurIPS 30.
- Neshov, N. et al. (2026). Visual-to-tactile cross-modal generation … Sensors 26, 426. Sec. 3.1.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from tactogram.models.visual_tactile_gan.config import Config
from tactogram.nn.initial_weights import normal_
from tactogram.nn.patch_discriminator import MultiScaleDiscriminator
from tactogram.nn.unet import UNet


class ConditionalBatchNorm(nn.Module):
    """``gamma(y) (x - mu) / sigma + beta(y)`` with ``gamma(y) = y Wg + bg`` and ``beta(y) = y Wb + bb``.

    mu and sigma are those of each channel over the batch and all places; in use, the running ones of training.
    ``channels`` is the paper's F, ``labels`` its C. Initial weights of the label are from N(0, ``gain``), bg = 1 and
    bb = 0: with a small gain it starts as plain batch normalisation.
    """

    def __init__(self, channels: int, labels: int, *, gain: float = 0.02) -> None:
        super().__init__()
        self.norm = nn.BatchNorm2d(channels, affine=False)
        self.scale = nn.Linear(labels, channels)
        self.shift = nn.Linear(labels, channels)
        nn.init.normal_(self.scale.weight, 0, gain)
        nn.init.ones_(self.scale.bias)
        nn.init.normal_(self.shift.weight, 0, gain)
        nn.init.zeros_(self.shift.bias)

    def forward(self, x: Tensor, label: Tensor) -> Tensor:
        """Return ``x``, (batch, channel, row, column), normalised, scaled and shifted.

        ``label``, (batch, C), is one-hot, or weights of several classes, of which scale and shift are weighted means.
        """
        gamma, beta = self.scale(label), self.shift(label)  # B, F
        normal: Tensor = self.norm(x)
        return torch.addcmul(beta[..., None, None], gamma[..., None, None], normal)


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
