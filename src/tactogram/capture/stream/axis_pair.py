"""Recorder of two axes of a source from a given moment, to measure the effect of a change."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.source import Source
from tactogram.errors import DeviceError, ParameterError

Array = NDArray[np.float64]

STALLED_S = 2.0
WAITED_S = 0.005


class PairRecorder:
    """Recorder of two axes of an entered source; samples that waited before are discarded.

    By default its first two axes, with ``full_scale`` as their largest magnitudes, V. Raises `ParameterError` if the
    source is not in V, has no nominal rate, or lacks the axes.
    """

    def __init__(
        self,
        source: Source,
        axes: tuple[str, str] | None = None,
        *,
        full_scale: tuple[float, float] = (np.inf, np.inf),
        clock: Callable[[], float] = monotonic,
    ) -> None:
        if source.unit != "V" or source.rate is None:
            raise ParameterError(
                f"{source.name}: voltage and current are measured in V at a known rate, got {source.unit} at "
                f"{source.rate}"
            )
        names = axes or source.axes[:2]
        if len(names) != 2 or names[0] == names[1] or not set(names) <= set(source.axes):
            raise ParameterError(
                f"{source.name}: needs two of its axes, voltage and current; it has {', '.join(source.axes)}"
            )
        self.name, self.rate, self.full_scale = source.name, float(source.rate), full_scale
        self._rows = [source.axes.index(name) for name in names]
        self._source, self._clock = source, clock

    def take(self, seconds: float, *, after_s: float) -> tuple[Array, Array]:
        """Return both axes from ``after_s`` on, V, float64, shape (time,) each; NaN where samples were lost.

        ``after_s`` is counted in samples rather than slept, because samples buffered by a driver are older than they
        seem. Raises `DeviceError` if no samples arrive for `STALLED_S`, or the source disappeared or ended.
        """
        # A quick source always has some more samples: a short block is the end of the waiting ones.
        while (waited := self._source.read(0.0)) is not None and len(waited) > WAITED_S * self.rate:
            pass
        skip, count = round(after_s * self.rate), round(seconds * self.rate)
        recorded = np.zeros((2, 0))
        last = self._clock()
        while recorded.shape[1] < count:
            block = self._source.read(0.1)
            if block is None:
                if self._clock() - last > STALLED_S:
                    raise DeviceError(f"{self.name}: no samples for {STALLED_S:g} s")
                continue
            last = self._clock()
            samples = np.asarray(block.samples[self._rows], np.float64)
            left = max(0, skip - samples.shape[1])
            recorded = np.concatenate([recorded, samples[:, skip - left :]], axis=1)
            skip = left
        return recorded[0, :count], recorded[1, :count]
