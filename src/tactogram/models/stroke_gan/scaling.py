"""Scale of a data set to the range of tanh, and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactogram.model import Example, Saved, SignalKind
from tactogram.signal import Signal

Array = NDArray[np.float64]
BINS = 1 << 16
"""Resolution of a signal's range: parts of its largest deviation."""


class Scaling(Saved):
    """One offset and one scale per axis for the whole data set.

    Per axis, so that a weak axis is not drowned by a strong one; the same for all materials, to keep their levels.
    The share ``within_range`` of the samples fits the range of tanh and the rest is clipped; 1 clips nothing.
    """

    saved = ("offset", "scale")

    def __init__(self, kind: SignalKind, within_range: float = 1.0) -> None:
        self.kind, self.within_range = kind, within_range
        self.offset = np.zeros(len(kind.axes))
        self.scale = np.ones(len(kind.axes))

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure the mean and the range of each axis; return the scales and the share that is clipped."""
        count = sum(len(example.signal) for example in examples)
        total = sum(example.signal.samples.sum(axis=1, dtype=np.float64) for example in examples)
        self.offset = np.asarray(total / count)
        largest = np.max([self._deviation(example).max(axis=1) for example in examples], axis=0)
        self.scale = np.where(largest > 0, largest, 1.0)
        if self.within_range < 1:
            self.scale *= [self._range(examples, axis) for axis in range(len(self.scale))]
        over = sum(
            int((self._deviation(example) > self.scale[:, None] * (1 + 1e-6)).sum()) for example in examples
        )
        scales = {f"scale_{axis}": float(s) for axis, s in zip(self.kind.axes, self.scale, strict=True)}
        return {**scales, "clipped_share": over / (count * len(self.scale))}

    def _deviation(self, example: Example) -> Array:
        deviation: Array = np.abs(example.signal.samples.astype(np.float64) - self.offset[:, None])
        return deviation

    def _range(self, examples: Sequence[Example], axis: int) -> float:
        """Return the share of the largest deviation that holds ``within_range`` of the samples."""
        counts = np.zeros(BINS, np.int64)
        for example in examples:
            place = (self._deviation(example)[axis] / self.scale[axis] * BINS).astype(np.int64)
            counts += np.bincount(np.minimum(place, BINS - 1), minlength=BINS)
        within = np.cumsum(counts) / counts.sum()
        return float((np.searchsorted(within, self.within_range) + 1) / BINS)

    def scaled(self, x: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return samples, shape (axis, time), within -1 to 1."""
        y = (x - self.offset[:, None]) / self.scale[:, None]
        return np.clip(y, -1, 1).astype(np.float32)

    def unscaled(self, y: NDArray[np.float32]) -> Signal:
        """Return samples within -1 to 1, shape (axis, time), as a signal."""
        x = y * self.scale[:, None] + self.offset[:, None]
        return self.kind.signal(x.astype(np.float32))
