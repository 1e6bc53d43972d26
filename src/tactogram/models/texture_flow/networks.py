"""U-Net over frequency and time, or rows and columns, conditioned on flow time and label.

References
----------
- Ronneberger, O., Fischer, P. & Brox, T. (2015). U-Net: convolutional networks for biomedical image segmentation.
  MICCAI.
- Perez, E. et al. (2018). FiLM: visual reasoning with a general conditioning layer. AAAI.
"""

from __future__ import annotations

import math
from itertools import pairwise

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from tactogram.models.texture_flow.config import Config

COSINES = 4
"""Cosines that tell the network the frequency, in rows."""
FASTEST = 400.0
"""Greatest angular frequency, rad, of the sinusoids that represent flow time."""


class VelocityUNet(nn.Module):
    """The velocity of every value of a spectrogram or image on its way from noise to texture.

    It has no fixed length: normalisation is over the channels of each place alone, so nothing far away matters.
    The last layer begins at 0. ``labels`` are the numbers of a label, which may change over columns; one of zeros is no
    condition. ``cosines`` tell the network the row; with none all rows are alike.
    """

    def __init__(self, config: Config, *, channels: int, labels: int, cosines: int = COSINES) -> None:
        super().__init__()
        widths, size = config.widths, config.embedding
        self.size, self.cosines = size, cosines
        self.label = nn.Linear(labels, size, bias=False)
        self.time = nn.Sequential(nn.Linear(size, size), nn.SiLU(), nn.Linear(size, size))
        self.embed = nn.Sequential(nn.SiLU(), nn.Linear(size, size), nn.SiLU())
        self.first = nn.Conv2d(channels + cosines, widths[0], 2, stride=2)
        levels = list(pairwise(widths))
        self.down = nn.ModuleList(_Block(fine, fine, size) for fine, _ in levels)
        self.coarser = nn.ModuleList(nn.Conv2d(fine, coarse, 2, stride=2) for fine, coarse in levels)
        self.middle = nn.ModuleList(_Block(widths[-1], widths[-1], size) for _ in range(2))
        self.finer = nn.ModuleList(nn.ConvTranspose2d(coarse, fine, 2, stride=2) for fine, coarse in levels)
        self.up = nn.ModuleList(_Block(2 * fine, fine, size) for fine, _ in levels)
        self.norm = _ChannelNorm(widths[0])
        self.last = _zeroed(nn.ConvTranspose2d(widths[0], channels, 2, stride=2))
        self.to(memory_format=torch.channels_last)  # type: ignore[call-overload]

    def forward(self, x: Tensor, time: Tensor, label: Tensor) -> Tensor:
        """Return the velocity, (batch, channel, row, column), at ``time``, (batch,), 0 to 1.

        ``label`` is (batch, label), or (batch, column, label).
        """
        batch, _, rows, columns = x.shape
        angles = torch.linspace(0, math.pi, rows, device=x.device)
        order = torch.arange(1, self.cosines + 1, device=x.device)
        cosines = torch.cos(order[:, None] * angles)[None, :, :, None].expand(batch, -1, -1, columns)
        label = label.view(batch, -1, label.shape[-1])
        e = self.embed(self.time(_sinusoids(time, self.size))[:, None] + self.label(label))  # B, 1 or C, E
        h = torch.cat((x, cosines), 1).contiguous(memory_format=torch.channels_last)
        h = self.first(h)  # B, W0, R/2, C/2
        skips = []
        for block, coarser in zip(self.down, self.coarser, strict=True):
            skips.append(block(h, e))
            h = coarser(skips[-1])  # B, Wk, R/2^(k+1), C/2^(k+1)
        for block in self.middle:
            h = block(h, e)
        for block, finer in zip(reversed(self.up), reversed(self.finer), strict=True):
            h = block(torch.cat((finer(h), skips.pop()), 1), e)
        velocity: Tensor = self.last(F.silu(self.norm(h)))  # B, channel, R, C
        return velocity


class _ChannelNorm(nn.LayerNorm):
    """Layer normalisation over the channels of each place."""

    def forward(self, x: Tensor) -> Tensor:
        return super().forward(x.permute(0, 2, 3, 1)).permute(0, 3, 1, 2)


class _Block(nn.Module):
    """Two convolutions with a skip connection; the condition scales and shifts the channels between them.

    The embedding of the condition, (batch, 1 or column, number), is averaged over the columns of a place.
    """

    def __init__(self, into: int, out: int, embedding: int) -> None:
        super().__init__()
        self.norms = nn.ModuleList((_ChannelNorm(into), _ChannelNorm(out)))
        self.convs = nn.ModuleList(
            (nn.Conv2d(into, out, 3, padding=1), _zeroed(nn.Conv2d(out, out, 3, padding=1)))
        )
        self.film = _zeroed(nn.Linear(embedding, 2 * out))
        self.skip = nn.Conv2d(into, out, 1) if into != out else nn.Identity()

    def forward(self, x: Tensor, e: Tensor) -> Tensor:
        h = self.convs[0](F.silu(self.norms[0](x)))
        e = e.view(len(e), min(e.shape[1], x.shape[-1]), -1, e.shape[-1]).mean(2)  # B, 1 or C, E
        scale, shift = self.film(e).mT[:, :, None].chunk(2, 1)  # B, W, 1, 1 or C
        h = self.convs[1](F.silu(self.norms[1](h) * (1 + scale) + shift))
        added: Tensor = self.skip(x) + h
        return added


def _sinusoids(time: Tensor, size: int) -> Tensor:
    """Return cosines and sines of ``time``, (batch,) -> (batch, size)."""
    angular = torch.logspace(0, math.log10(FASTEST), size // 2, device=time.device)
    angle = time[:, None] * angular
    return torch.cat((angle.cos(), angle.sin()), 1)


def _zeroed(layer: nn.Module) -> nn.Module:
    for parameter in layer.parameters():
        nn.init.zeros_(parameter)
    return layer
