"""A finger's way over a photograph of any width, window by window, and their spectrograms made one."""

from __future__ import annotations

import torch
from torch import Tensor


def journey(width: int, pixels: int, step: float, count: int) -> list[tuple[int, bool]]:
    """Return the first columns of ``count`` windows, and whether the finger comes back there (mirrored windows).

    From the left edge on, each ``step`` of a window further; at the right edge it turns round, and so on. A
    photograph as wide as a window is met over and over.

    Parameters
    ----------
    width, pixels : int
        Columns of the photograph and of a window.
    step : float
        As a share of a window.
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
    """Return one long spectrogram of several that begin ``hop`` frames after each other.

    Where they overlap each counts by its distance to its nearer end (a triangle), so that nothing jumps. One phase
    recovery of the whole then has no seams at all.

    Parameters
    ----------
    magnitudes : Tensor, shape (window, axis, bin, frame)
    hop : int, frames

    Returns
    -------
    Tensor, shape (axis, bin, (window - 1) * hop + frames)
    """
    windows, axes, bins, frames = magnitudes.shape
    ramp = torch.arange(1, frames + 1, dtype=magnitudes.dtype)
    weight = torch.minimum(ramp, ramp.flip(0))
    total = magnitudes.new_zeros(axes, bins, (windows - 1) * hop + frames)
    cover = magnitudes.new_zeros(total.shape[-1])
    for number, one in enumerate(magnitudes):
        part = slice(number * hop, number * hop + frames)
        total[..., part] += weight * one
        cover[part] += weight
    return total / cover
