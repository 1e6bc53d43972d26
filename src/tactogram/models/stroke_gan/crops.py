"""Pieces of recordings as long as the network's signals, cut at random from recordings made long enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.model import Example
from tactogram.models.stroke_gan.config import Config
from tactogram.signal import Signal
from tactogram.signal.joining import extend
from tactogram.training.seeds import child_rng


@dataclass(frozen=True)
class Crops:
    """An endless row of crops: epoch after epoch, in each every recording in an order of its own.

    Crop k depends on the seed and k alone. Nothing but the crops asked for is read.

    Parameters
    ----------
    examples : sequence of Example
    config : Config
    lead : int
        Samples before each crop that are wanted too.
    """

    examples: Sequence[Example]
    config: Config
    lead: int = 0

    @property
    def length(self) -> int:
        """Samples of a crop, with what is wanted before it."""
        return self.config.length + self.lead

    def epoch(self, lengths: Sequence[int]) -> NDArray[np.int64]:
        """Return the number of each recording as often as an epoch crops it, int64, shape (crop,)."""
        times = [max(1, length // self.config.length) for length in lengths]
        return np.repeat(np.arange(len(lengths)), times)

    def draw(self, start: int, count: int, *, seed: int) -> list[tuple[Example, NDArray[np.float32]]]:
        """Return crops ``start`` to ``start + count``: their recording, and float32 (axis, lead + length)."""
        lengths = [len(example.signal) for example in self.examples]
        members = self.epoch(lengths)
        drawn = []
        for number in range(start, start + count):
            epoch, place = divmod(number, len(members))
            order = child_rng(seed, "epoch", epoch).permutation(len(members))
            example = self.examples[members[order[place]]]
            rng = child_rng(seed, "crop", number)
            drawn.append((example, self.cut(example.signal, rng)))
        return drawn

    def cut(self, signal: Signal, rng: np.random.Generator) -> NDArray[np.float32]:
        """Return a crop of ``signal``, float32, shape (axis, lead + length); each place is equally likely."""
        size, length = len(signal), self.length
        if size >= length:
            start = int(rng.integers(size - length + 1))
            return np.array(signal.samples[:, start : start + length])
        if self.config.repetition == "repeat":
            # What `joining.repeat` gives, read where it is cut.
            times = max(self.config.repetitions, -(-length // size))
            start = int(rng.integers(times * size - length + 1))
            return np.take(signal.samples, np.arange(start, start + length), axis=1, mode="wrap")
        overlap = min(round(self.config.overlap * self.config.length), size // 3)
        begin = int(rng.integers(size - 2 * overlap))
        joined = extend(
            lambda number: signal.cut(0 if number else begin),
            seconds=length / signal.rate,
            overlap_s=overlap / signal.rate,
        )
        return np.array(joined.samples)
