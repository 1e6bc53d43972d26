"""Cutting sets of signals to pieces of equal length and number before comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactogram.errors import ParameterError
from tactogram.signal import Signal

LONGEST_S, SHORTEST_S = 2.0, 1.0
"""Limits of a piece's length, s. Recordings below the lower limit are left out where every material has longer ones."""
MOST_PIECES = 12
"""Pieces per material and set: bounds the time that an evaluation takes."""


@dataclass(frozen=True, eq=False)
class PieceSet:
    """Pieces of one length; ``groups`` numbers the signals that they were cut from."""

    signals: tuple[Signal, ...]
    groups: tuple[int, ...]


@dataclass(frozen=True)
class PiecePlan:
    """Length of pieces, and their number per material."""

    seconds: float
    count: int

    def cut(self, signals: Sequence[Signal]) -> PieceSet:
        """Return ``count`` pieces, spread evenly over ``signals``; `ParameterError` if there are fewer."""
        length = max(1, round(self.seconds * signals[0].rate)) if signals else 1
        pieces = [
            (signal.cut(start, start + length), group)
            for group, signal in enumerate(signals)
            for start in range(0, len(signal) - length + 1, length)
        ]
        if len(pieces) < self.count:
            raise ParameterError(
                f"{self.count} pieces of {self.seconds:g} s are needed, the signals hold {len(pieces)}"
            )
        spread = [pieces[k] for k in (np.arange(self.count) * len(pieces)) // self.count]
        return PieceSet(tuple(piece for piece, _ in spread), tuple(group for _, group in spread))

    def draws(self, recordings: Sequence[Signal]) -> tuple[int, float]:
        """Return number and length (s) of the signals to generate in place of ``recordings``.

        As many signals as `cut` uses recordings: pieces of one signal are more alike than pieces of several.
        """
        number = len(set(self.cut(recordings).groups))
        return number, -(-self.count // number) * self.seconds


def plan_pieces(
    train: Mapping[str, Sequence[Signal]],
    test: Mapping[str, Sequence[Signal]],
    *,
    longest_s: float = LONGEST_S,
    most: int = MOST_PIECES,
) -> PiecePlan:
    """Return the largest plan that the recordings of every material of ``test`` allow.

    Pieces are as long as possible up to ``longest_s``, with little remainder; recordings shorter than `SHORTEST_S` are
    left out where every material has longer ones. The number is that of the material with the fewest pieces in either
    part, up to ``most``. Raises `ParameterError` if ``longest_s`` or ``most`` is not positive.
    """
    if not (longest_s > 0 and most >= 1):
        raise ParameterError(f"longest_s must be > 0 and most >= 1, got {longest_s:g} and {most}")
    every = [part[material] for part in (train, test) for material in test]
    rate = every[0][0].rate
    length = min(len(signal) for signals in every for signal in signals)
    if length < SHORTEST_S * rate:
        length = min(round(SHORTEST_S * rate), *(max(map(len, signals)) for signals in every))
    length = max(1, length // int(np.ceil(length / (longest_s * rate) - 1e-9)))
    count = min(sum(len(signal) // length for signal in signals) for signals in every)
    return PiecePlan(length / rate, min(count, most))
