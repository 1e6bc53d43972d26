"""Path of a finger over a photograph of any width, window by window, and the joint spectrogram."""

from __future__ import annotations

import torch
from torch import Tensor


def journey(width: int, pixels: int, step: float, count: int) -> list[tuple[int, bool]]:
    """Return the first columns of ``count`` windows, and whether the finger moves back there (mirrored windows).

    From the left edge of ``width`` columns on, each ``step`` (a share of a window) further; the finger turns round at
    the edges. A photograph as wide as a window repeats.
    """
    room = width - pixels
    if room <= 0:
        return [(0, False)] * count
    places = []
    for number in range(count):
        way = number * step * pixels % (2 * room)
        back = way > room
        places.append((round(2 * room - way if back else way), back))
    return places


def spliced(magnitudes: Tensor, hop: int) -> Tensor:
    """Return one long spectrogram, (axis, bin, frame), of several, (window, axis, bin, frame), ``hop`` frames apart.

    In overlaps each counts by the distance to its nearer end (a triangle), which avoids jumps. One phase recovery of
    the whole then has no seams.
    """
    windows, axes, bins, frames = magnitudes.shape
    ramp = torch.arange(1, frames + 1, dtype=magnitudes.dtype)
    weight = torch.minimum(ramp, ramp.flip(0))
    total = magnitudes.new_zeros(axes, bins, (windows - 1) * hop + frames)
    cover = magnitudes.new_zeros(total.shape[-1])
    for number, magnitude in enumerate(magnitudes):
        part = slice(number * hop, number * hop + frames)
        total[..., part] += weight * magnitude
        cover[part] += weight
    return total / cover
