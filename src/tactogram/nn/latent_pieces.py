"""Signals of any length from a generator of a fixed length: pieces of new latents, crossfaded."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.model import Condition, SignalKind
from tactogram.signal import Signal
from tactogram.signal.joining import extend

AT_ONCE = 8
"""Maximum number of pieces per batch."""

Make = Callable[[int, int], NDArray[np.float32]]
"""Maps the number of the first piece and the count to pieces, float32 (piece, axis, time)."""


def crossfaded_pieces(make: Make, kind: SignalKind, *, length: int, overlap: int) -> NDArray[np.float32]:
    """Return pieces 0, 1, 2, …, each crossfaded into the next: float32, shape (axis, length).

    Lengths are in samples. A longer signal begins like a shorter one.
    """
    pieces = _Pieces(make)
    signal = extend(
        lambda number: Signal(pieces[number], kind.rate, "1", kind.axes),
        seconds=length / kind.rate,
        overlap_s=overlap / kind.rate,
    )
    return signal.samples


class _Pieces:
    """Pieces in order, generated in batches of 1, 1, 2, 4, 8, 8, …, so that piece k is the same in every signal."""

    def __init__(self, make: Make) -> None:
        self.make = make
        self.first, self.made = 0, np.empty((0, 0, 0), np.float32)

    def __getitem__(self, number: int) -> NDArray[np.float32]:
        """Return a piece, shape (axis, time); none before the last batch."""
        if number >= self.first + len(self.made):
            self.first += len(self.made)
            self.made = self.make(self.first, min(max(1, self.first), AT_ONCE))
        piece: NDArray[np.float32] = self.made[number - self.first]
        return piece


def uniform_latents(
    first: int,
    count: int,
    size: int,
    *,
    given: Mapping[int, Tensor],
    rng: Callable[[int], np.random.Generator],
) -> Tensor:
    """Return the latents of pieces ``first`` to ``first + count``: float32, shape (piece, size), in -1 to 1.

    ``given`` are latents, shape (size,), of some pieces by number; the others are drawn by the ``rng`` of their number.
    """
    latents = []
    for number in range(first, first + count):
        drawn = torch.from_numpy(rng(number).uniform(-1, 1, size).astype(np.float32))
        latents.append(given.get(number, drawn))
    return torch.stack(latents)


def given_latent(condition: Condition, size: int, *, piece: int = 0) -> dict[int, Tensor]:
    """Return the condition ``latent``, shape (size,), in -1 to 1, as that of ``piece``; empty if there is none."""
    if condition.get("latent") is None:
        return {}
    latent = np.asarray(condition["latent"], np.float32)
    if latent.shape != (size,) or not (np.abs(latent) <= 1).all():
        raise ParameterError.must("latent", f"be {size} numbers in -1 to 1, got shape {latent.shape}")
    return {piece: torch.from_numpy(latent)}
