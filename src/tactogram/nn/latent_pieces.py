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
"""Pieces that are made together, at most."""

Make = Callable[[int, int], NDArray[np.float32]]
"""From the number of a piece, and how many, to float32 (piece, axis, time)."""


def crossfaded_pieces(make: Make, kind: SignalKind, *, length: int, overlap: int) -> NDArray[np.float32]:
    """Return pieces 0, 1, 2, …, each crossfaded into the next: float32, shape (axis, length).

    A longer signal begins as a shorter one does.

    Parameters
    ----------
    make : callable
    kind : SignalKind
        Its rate and axes.
    length : int
        Samples.
    overlap : int
        Samples of a crossfade.
    """
    pieces = _Pieces(make)
    signal = extend(
        lambda number: Signal(pieces[number], kind.rate, "1", kind.axes),
        seconds=length / kind.rate,
        overlap_s=overlap / kind.rate,
    )
    return signal.samples


class _Pieces:
    """Pieces in order, made 1, 1, 2, 4, 8, 8, … at a time, so that piece k is the same in every signal."""

    def __init__(self, make: Make) -> None:
        self.make = make
        self.first, self.made = 0, np.empty((0, 0, 0), np.float32)

    def __getitem__(self, number: int) -> NDArray[np.float32]:
        """Return one piece, shape (axis, time); none before those that were made last."""
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

    Parameters
    ----------
    first, count, size : int
    given : mapping of int to Tensor, shape (size,)
        Latents of some pieces, by their number; the others are drawn.
    rng : callable
        From the number of a piece to its random generator.
    """
    latents = []
    for number in range(first, first + count):
        drawn = torch.from_numpy(rng(number).uniform(-1, 1, size).astype(np.float32))
        latents.append(given.get(number, drawn))
    return torch.stack(latents)


def given_latent(condition: Condition, size: int, *, piece: int = 0) -> dict[int, Tensor]:
    """Return the condition ``latent``, float32, shape (size,), as that of ``piece``; nothing where there is none.

    Raises
    ------
    ParameterError
        If it has another shape, or a number outside of -1 to 1.
    """
    given = condition.get("latent")
    if given is None:
        return {}
    latent = np.asarray(given, np.float32)
    if latent.shape != (size,) or not (np.abs(latent) <= 1).all():
        raise ParameterError(f"latent must be {size} numbers in -1 to 1, got shape {latent.shape}")
    return {piece: torch.from_numpy(latent)}
