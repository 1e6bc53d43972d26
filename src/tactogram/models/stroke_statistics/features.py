"""Statistics of a stretch of a stroke that tell surfaces apart and not where a ridge happened to lie.

A texture is stationary: what names it are the levels of its bands, how they fluctuate and go together, and how its
values are distributed, as for sound textures (McDermott and Simoncelli 2011, "Sound texture perception via statistics
of the auditory periphery"). Short frames follow single contacts, long ones resolve tones, so bands are measured in
frames of several lengths. Levels are kept: how strongly a surface shakes the tool is part of what it is.
"""

from __future__ import annotations

import math
from itertools import combinations, pairwise

import torch
from torch import Tensor, nn

LENGTHS = (16, 64, 256)
"""Samples of the frames, of those that a window holds `FRAMES_LEAST` times: single contacts, to tones."""
FRAMES_LEAST = 4
SHARES = (-2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0)
"""Standard deviations above which the share of the samples is a feature."""
RARE = (3.0, 4.0)
"""Standard deviations beyond which, to either side, it is one, too: impacts."""
DERIVATIVES = 3
"""The signal and its first two differences."""
SILENT = 1e-6
"""Standard deviation, as a share of that of the training signals, that counts as silence."""
FLOOR_DB = -90.0
"""Level of a band in a frame below the mean of the window that counts as silence."""


def band_edges(length: int) -> list[int]:
    """Return edges of bands as bins of a frame's spectrum without its mean: single bins first, then geometric."""
    bins = length // 2
    count = min(bins, 8 * (int(math.log2(length)) - 3))
    return sorted({round((bins + 1) ** (k / count)) - 1 for k in range(count + 1)})


class Statistics(nn.Module):
    """Features of windows, (window, axis, time) -> (window, feature), by products of matrices that any runtime has."""

    def __init__(self, axes: int, samples: int) -> None:
        super().__init__()
        self.axes, self.samples = axes, samples
        self.lengths = [length for length in LENGTHS if length * FRAMES_LEAST <= samples]
        for length in self.lengths:
            self.register_buffer(f"spectrum_{length}", _hann_spectrum(length), persistent=False)
            self.register_buffer(f"bands_{length}", _bands(length), persistent=False)
        self.count = self(torch.zeros(1, axes, samples)).shape[1]
        """Features of a window."""

    def forward(self, x: Tensor) -> Tensor:
        """Return the features, (window, feature), of windows in units of the training signals, (window, axis, time)."""
        features = self._distribution(x)
        for length in self.lengths:
            features += self._bands(x, length)
        return torch.cat([feature.flatten(1) for feature in features], 1)

    def _distribution(self, x: Tensor) -> list[Tensor]:
        """Return the features of the values and of their differences, each (window, axis) or (window, pair of axes)."""
        features = []
        for _ in range(DERIVATIVES):
            centred = x - x.mean(2, keepdim=True)
            deviation = centred.square().mean(2, keepdim=True).sqrt() + SILENT
            z = centred / deviation
            features += [20 * deviation.log10(), (z.pow(4).mean(2) + SILENT).log()]
            features += [(z[..., 1:] * z[..., :-1] < 0).float().mean(2)]
            features += [(z > share).float().mean(2) for share in SHARES]
            features += [(z.abs() > rare).float().mean(2) for rare in RARE]
            features += [
                (z[:, a] * z[:, b]).mean(1, keepdim=True) for a, b in combinations(range(self.axes), 2)
            ]
            x = x[..., 1:] - x[..., :-1]
        return features

    def _bands(self, x: Tensor, length: int) -> list[Tensor]:
        """Return the features of the bands of frames of ``length`` samples, each (window, axis, band)."""
        frames = x.unfold(2, length, length // 2)  # W, A, F, T
        cosine_sine = frames @ getattr(self, f"spectrum_{length}")  # W, A, F, 2 B
        power = cosine_sine.square() @ getattr(self, f"bands_{length}")  # W, A, F, band
        least = 10 ** (FLOOR_DB / 10) * power.mean((2, 3), keepdim=True) + SILENT**2
        level = 10 * (power + least).log10()
        mean = level.mean(2, keepdim=True)
        centred = level - mean
        deviation = centred.square().mean(2, keepdim=True).sqrt() + SILENT
        z = centred / deviation
        change = level[:, :, 1:] - level[:, :, :-1]
        change = change - change.mean(2, keepdim=True)
        return [
            10 * (power.mean(2) + SILENT**2).log10(), mean, deviation, change.square().mean(2).sqrt(),
            (z[..., 1:] * z[..., :-1]).mean(2),
        ]  # fmt: skip


def _hann_spectrum(length: int) -> Tensor:
    """Return the matrix of a frame's Fourier transform under a Hann window without its mean: (time, 2 bins)."""
    time = torch.arange(length, dtype=torch.float64)
    window = torch.hann_window(length, periodic=True, dtype=torch.float64)
    angle = 2 * math.pi / length * time[:, None] * torch.arange(1, length // 2 + 1)
    scale = window / (window.square().sum() * length).sqrt()
    return (scale[:, None] * torch.cat([angle.cos(), angle.sin()], 1)).float()


def _bands(length: int) -> Tensor:
    """Return the matrix that sums squared cosine and sine parts by bands: (2 bins, band)."""
    edges = band_edges(length)
    bins = torch.zeros(length // 2, len(edges) - 1)
    for band, (low, high) in enumerate(pairwise(edges)):
        bins[low:high, band] = 1
    return torch.cat([bins, bins])
