"""Generator of Saga et al., Table III. Tensors are (batch * axis, channel, time)."""

from __future__ import annotations

from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.stroke_gan.config import Config
from tactogram.nn import glorot_linear, strided_conv_transpose


class Generator(nn.Module):
    """Latent and label to a signal of A axes, 3 in the paper; C labels, one per class.

    Each axis is convolved separately, with shared filters.
    """

    def __init__(self, config: Config, *, axes: int, labels: int) -> None:
        super().__init__()
        self.leak = config.leak
        self.shape = (axes, config.points, config.channels[0])
        self.dense = glorot_linear(config.latent + labels, axes * config.points * config.channels[0])
        self.layers = nn.ModuleList(
            strided_conv_transpose(coarse, fine, kernel=config.kernel, stride=config.stride)
            for coarse, fine in pairwise((*config.channels, 1))
        )

    def forward(self, latent: Tensor, label: Tensor) -> Tensor:
        """Return signals within -1 to 1: (batch, latent) and (batch, C) -> (batch, axis, time)."""
        h = self.dense(torch.cat((latent, label), 1))  # B, A * 16 * 1024
        h = h.unflatten(1, self.shape).flatten(0, 1).transpose(1, 2)  # B A, 1024, 16
        for layer in self.layers:
            h = layer(F.leaky_relu(h, self.leak))  # B A, C / 2, 4 T; the last B A, 1, 16384
        return torch.tanh(h.view(latent.shape[0], self.shape[0], -1))  # B, A, 16384
