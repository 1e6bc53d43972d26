"""Generator and discriminator of Saga et al., Table III. Tensors are (batch, axis, time, channel), as there."""

from __future__ import annotations

from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.stroke_gan.config import Config
from tactogram.nn import StridedConvTranspose, WaveDiscriminator, glorot_linear


class Generator(nn.Module):
    """Latent and label to a signal. Each axis is convolved on its own, with shared filters.

    Parameters
    ----------
    config : Config
    axes : int
        A; 3 in the paper.
    labels : int
        C: one per class.
    """

    def __init__(self, config: Config, *, axes: int, labels: int) -> None:
        super().__init__()
        self.leak = config.leak
        self.shape = (axes, config.points, config.channels[0])
        self.dense = glorot_linear(config.latent + labels, axes * config.points * config.channels[0])
        self.layers = nn.ModuleList(
            StridedConvTranspose(coarse, fine, kernel=config.kernel, stride=config.stride)
            for coarse, fine in pairwise((*config.channels, 1))
        )

    def forward(self, latent: Tensor, label: Tensor) -> Tensor:
        """Return signals within -1 to 1: (batch, latent) and (batch, C) -> (batch, axis, time)."""
        h = self.dense(torch.cat((latent, label), 1))  # B, A * 16 * 1024
        h = h.unflatten(1, self.shape)  # B, A, 16, 1024
        for layer in self.layers:
            h = layer(F.leaky_relu(h, self.leak))  # B, A, 4 T, C / 2; the last B, A, 16384, 1
        return torch.tanh(h[..., 0])  # B, A, 16384


def discriminator(config: Config, *, axes: int, labels: int) -> WaveDiscriminator:
    """Return the discriminator of Table III: the generator's layers backwards, and phase shuffle between them."""
    return WaveDiscriminator(
        channels=config.channels,
        points=config.points,
        kernel=config.kernel,
        stride=config.stride,
        leak=config.leak,
        phase_shuffle=config.phase_shuffle,
        axes=axes,
        labels=labels,
    )
