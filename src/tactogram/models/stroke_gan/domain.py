"""What the networks see of a signal, and the way back: its scale taken out, or what a filter foresees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tactogram.model import Example, SignalKind
from tactogram.models.stroke_gan.config import Config
from tactogram.models.stroke_gan.whitened import Whitened
from tactogram.signal import Signal

Array = NDArray[np.float64]
BINS = 1 << 16
"""Resolution of the range of a signal: its largest deviation over this."""


class Domain(Protocol):
    """Both directions, and what was fitted; saved with the weights."""

    @property
    def lead(self) -> int:
        """Samples before a crop that `inside` needs."""
        ...

    @property
    def settle(self) -> int:
        """Samples that `outside` needs before those it gives."""
        ...

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure the training part and return figures on it."""
        ...

    def inside(self, x: NDArray[np.float32], material: int) -> NDArray[np.float32]:
        """Return (axis, lead + time) samples of a recording as (axis, time) for the networks."""
        ...

    def outside(self, y: NDArray[np.float32], weights: NDArray[np.float64]) -> Signal:
        """Return (axis, settle + time) samples of the networks as a signal; ``weights`` are by material."""
        ...

    def state(self) -> dict[str, Any]:
        """Return what was fitted."""
        ...

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`."""
        ...


class Scaled:
    """One offset and one scale per axis for the whole data set, such that tanh's range holds the signals.

    Per axis, so that a weak axis is not lost beside a strong one; one for all materials, so that their levels
    stay apart. What lies beyond ``config.within_range`` of the samples is clipped: `fit` says how much.
    """

    lead = settle = 0

    def __init__(self, config: Config, kind: SignalKind) -> None:
        self.config, self.kind = config, kind
        self.offset = np.zeros(len(kind.axes))
        self.scale = np.ones(len(kind.axes))

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Measure the mean and the range of each axis; memory stays flat."""
        count = sum(len(example.signal) for example in examples)
        total = sum(example.signal.samples.sum(axis=1, dtype=np.float64) for example in examples)
        self.offset = np.asarray(total / count)
        largest = np.max([self._deviation(example).max(axis=1) for example in examples], axis=0)
        self.scale = np.where(largest > 0, largest, 1.0)
        if self.config.within_range < 1:
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
        return float((np.searchsorted(within, self.config.within_range) + 1) / BINS)

    def inside(self, x: NDArray[np.float32], material: int) -> NDArray[np.float32]:
        y = (x - self.offset[:, None]) / self.scale[:, None]
        return np.clip(y, -1, 1).astype(np.float32)

    def outside(self, y: NDArray[np.float32], weights: NDArray[np.float64]) -> Signal:
        x = y * self.scale[:, None] + self.offset[:, None]
        return Signal(x.astype(np.float32), self.kind.rate, self.kind.unit, self.kind.axes)

    def state(self) -> dict[str, Any]:
        return {"offset": self.offset, "scale": self.scale}

    def load_state(self, state: Mapping[str, Any]) -> None:
        self.offset = np.asarray(state["offset"], np.float64)
        self.scale = np.asarray(state["scale"], np.float64)


def domain_of(config: Config, kind: SignalKind) -> Domain:
    """Return what ``config.residual`` asks for."""
    return Whitened(config, kind) if config.residual == "autoregressive" else Scaled(config, kind)
