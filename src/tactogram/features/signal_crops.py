"""Random crops of recordings, as long as the signals of a network."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.model import Example
from tactogram.signal import Signal
from tactogram.signal.joining import extend

Rng = Callable[[str, int], np.random.Generator]
"""From a purpose, ``"epoch"`` or ``"crop"``, and its number to a random generator."""
Epoch = Literal["recordings", "slices", "crops"]
"""Crops of an epoch: one of each recording, or one per whole length in it; one per whole length in each recording *as
repeated*; or as many as a repeated recording has places to begin."""


@dataclass(frozen=True)
class SignalCrops:
    """An endless sequence of crops: epoch after epoch, each with every recording in a new order.

    Crop k depends on the random generators and k alone. Only the drawn crops are read.

    Recordings shorter than ``length`` samples are joined to themselves by crossfades of ``overlap`` samples, at most a
    third of the recording, or with ``repetitions`` put end to end as often, more if still too short. ``lead`` are
    further samples before each crop. ``covers`` defines an epoch.
    """

    examples: Sequence[Example]
    length: int
    overlap: int
    repetitions: int | None = None
    lead: int = 0
    covers: Epoch = "recordings"

    @cached_property
    def epoch(self) -> NDArray[np.int64]:
        """Number of each recording, as often as an epoch crops it: int64, shape (crop,); reads all of them once."""
        times = [self._times(len(example.signal)) for example in self.examples]
        return np.repeat(np.arange(len(times)), times)

    def _times(self, size: int) -> int:
        if self.covers != "recordings" and size < self.length and self.repetitions is not None:
            size *= self.repetitions
        return max(1, size - self.length + 1 if self.covers == "crops" else size // self.length)

    def draw(self, start: int, count: int, rng: Rng) -> list[tuple[Example, NDArray[np.float32]]]:
        """Return crops ``start`` to ``start + count``: each recording, and float32 (axis, lead + length)."""
        return self.at(range(start, start + count), rng)

    def at(self, numbers: Iterable[int], rng: Rng) -> list[tuple[Example, NDArray[np.float32]]]:
        """Return the crops of these numbers, as `draw` does."""
        members = self.epoch
        drawn, orders = [], dict[int, NDArray[np.int64]]()
        for number in numbers:
            epoch, index = divmod(number, len(members))
            if epoch not in orders:
                orders[epoch] = rng("epoch", epoch).permutation(len(members))
            order = orders[epoch]
            example = self.examples[members[order[index]]]
            drawn.append((example, self.cut(example.signal, rng("crop", number))))
        return drawn

    def cut(self, signal: Signal, rng: np.random.Generator) -> NDArray[np.float32]:
        """Return a crop of ``signal``, float32, shape (axis, lead + length), from a uniform random place."""
        size, length = len(signal), self.lead + self.length
        if size >= length:
            start = int(rng.integers(size - length + 1))
            return np.array(signal.samples[:, start : start + length])
        if self.repetitions is not None:
            # A crop of the repeated recording, without creating all of it.
            times = max(self.repetitions, -(-length // size))
            start = int(rng.integers(times * size - length + 1))
            return np.take(signal.samples, np.arange(start, start + length), axis=1, mode="wrap")
        overlap = min(self.overlap, size // 3)
        begin = int(rng.integers(size - 2 * overlap))
        joined = extend(
            lambda number: signal.cut(0 if number else begin),
            seconds=length / signal.rate,
            overlap_s=overlap / signal.rate,
        )
        return np.array(joined.samples)
