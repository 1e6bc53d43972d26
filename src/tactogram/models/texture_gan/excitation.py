"""White noise in bands, for a generator that shapes each."""

from __future__ import annotations

import math

import torch
from torch import Tensor


def white_noise(batch: int, axes: int, time: int, *, generator: torch.Generator | None = None) -> Tensor:
    """Return normal numbers, float32, (batch, axis, time), on the CPU."""
    return torch.randn(batch, axes, time, generator=generator)


def split_bands(noise: Tensor, bands: int) -> Tensor:
    """Return ``noise`` in octaves, the top one of a half of the band: (…, time) -> (…, time, band).

    Neighbours cross over in the octave between their centres; all bands sum to ``noise``.
    """
    time = noise.shape[-1]
    spectrum = torch.fft.rfft(noise)
    place = torch.arange(spectrum.shape[-1], device=noise.device) / (time / 2)  # 0..1 of half the rate
    octave = torch.log2(place.clamp(min=2.0**-30)) + bands - 0.5  # 0 at the edge below band 1
    gains = torch.ones(bands + 1, len(place), device=noise.device)
    for edge in range(1, bands):
        across = (octave - edge + 1).clamp(0, 1) * (math.pi / 2)
        gains[edge - 1] *= across.cos() ** 2
        gains[edge] *= across.sin() ** 2
    return torch.stack([torch.fft.irfft(spectrum * gain, time) for gain in gains[:bands]], -1)
