"""Feed of a source: its recent blocks, and the level meter."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram_capture.session.take import Take, joined, level, rate_of
from tactogram_capture.source import Block, Source, SourceLost

METER_S = 0.25
"""Interval of the level meter, s."""

MEASURED_S = 0.5
"""Interval between updates of the measured rate, s."""


@dataclass(frozen=True)
class MeterReading:
    """Reading of a level meter."""

    rms: float
    """Of the last `METER_S`, about the mean, root of the sum of squares over axes, source's unit."""
    peak: float
    """Largest magnitude of any axis, gravity and offsets included, since these clip, too."""
    full_scale: float | None
    clipped: bool
    """Whether ``peak`` reached ``full_scale``."""
    lost: int
    """Samples lost since the source was opened."""
    rate: float | None
    """Measured, Hz."""


START_S = 10.0
"""Silence before the first sample that is no loss, s: opening its port resets a board, which then starts."""


class Feed:
    """Reader of an open source with a buffer.

    ``reference_rate`` (nominal, Hz) and ``full_scale`` are by default the source's. After ``silence_s`` without
    samples the source counts as lost, at its start after `START_S`.
    """

    def __init__(
        self,
        source: Source,
        *,
        reference_rate: float | None = None,
        full_scale: float | None = None,
        silence_s: float = 3.0,
        clock: Callable[[], float] = monotonic,
    ) -> None:
        self.source = source
        self._reference = reference_rate
        self.full_scale = full_scale if full_scale is not None else getattr(source, "full_scale", None)
        self.lost = 0
        """Samples lost so far."""
        self.next_index = 0
        """Position of the next sample."""
        self._silence_s, self._clock = silence_s, clock
        self._last_arrival_s = clock()
        self._buffer: deque[Block] = deque()
        self._from: int | None = None
        self.keep_s = METER_S
        """Minimum length of the buffer, s."""
        self.first_arrival_s = float("nan")
        """Arrival of the first block."""
        self._measured: Mapping[str, float] | None = None
        self._measured_at = -1

    @property
    def reference_rate(self) -> float | None:
        """Nominal rate, Hz."""
        return self._reference if self._reference is not None else self.source.rate

    @reference_rate.setter
    def reference_rate(self, rate: float | None) -> None:
        self._reference = rate

    @property
    def measured_rate(self) -> Mapping[str, float] | None:
        """Rate measured by the source: ``hz``, ``low``, ``high``; None while unknown."""
        # A robust fit to hundreds of arrivals is too slow for every update of the meter.
        if self.next_index != self._measured_at and (
            self._measured is None or self.next_index >= self._measured_at + MEASURED_S * self._measured["hz"]
        ):
            self._measured = self.source.facts().get("rate") or None
            self._measured_at = self.next_index
        return self._measured

    @property
    def rate(self) -> float | None:
        """Rate to write a take with, Hz; None while unknown."""
        return rate_of(self.measured_rate, self.reference_rate)

    def poll(self, timeout_s: float = 0.1, *, patient: bool = False) -> Block | None:
        """Read one block, or None if none arrived in time; ``patient`` tolerates any silence.

        Raises `SourceEnded` and `SourceLost` as `Source.read`; `SourceLost` also after ``silence_s`` without samples.
        """
        block = self.source.read(timeout_s)
        now = self._clock()
        if block is None:
            silent = now - self._last_arrival_s
            if patient:
                self._last_arrival_s = now
            elif silent > (self._silence_s if self.next_index else max(self._silence_s, START_S)):
                advice = getattr(self.source, "silence", lambda: "is it switched on and within range?")()
                raise SourceLost(
                    f"{self.source.name.partition('?')[0]}: no samples for {silent:.1f} s; {advice}"
                )
            return None
        self._last_arrival_s = now
        if not self.next_index:
            self.first_arrival_s = block.arrival_s
        self._buffer.append(block)
        self.lost += block.lost
        self.next_index = block.first_index + len(block)
        self._forget()
        return block

    def mark(self) -> int:
        """Keep all samples from the next one on, and return its position."""
        self._from = self.next_index
        return self.next_index

    def take(self, start: int, stop: int) -> Take:
        """Return samples ``start`` to ``stop`` (exclusive), kept since `mark`.

        Raises `DataError` if there are none, or the rate is still unknown.
        """
        self._measured, self._measured_at = None, -1
        measured, rate = self.measured_rate, self.rate
        if rate is None:
            raise DataError(
                self.source.name, "the rate is still unknown; let the source run for some seconds"
            )
        samples = joined(self._buffer, start=start, stop=stop)
        hz = None if measured is None else measured["hz"]
        return Take(samples, self.source.axes, self.source.unit, rate, hz, start)

    def release(self) -> None:
        """Stop keeping samples since `mark`."""
        self._from = None
        self._forget()

    def levels(self) -> MeterReading:
        """Return the reading of the level meter."""
        recent = self.recent(METER_S)
        received = recent[:, np.isfinite(recent).all(axis=0)]
        peak = float(np.abs(received).max()) if received.size else 0.0
        clipped = self.full_scale is not None and peak >= 0.999 * self.full_scale
        measured = self.measured_rate
        hz = None if measured is None else measured["hz"]
        return MeterReading(level(recent), peak, self.full_scale, clipped, self.lost, hz)

    def recent(self, seconds: float) -> NDArray[np.float32]:
        """Return the latest samples, float32, shape (axis, time), NaN where lost; none while the rate is unknown."""
        rate = self.rate
        count = 0 if rate is None else round(seconds * rate)
        parts: list[NDArray[np.float32]] = []
        for block in reversed(self._buffer):
            if count <= 0:
                break
            parts.append(block.samples[:, -count:])
            count -= len(block)
        if not parts:
            return np.zeros((max(1, len(self.source.axes)), 0), np.float32)
        return np.concatenate(parts[::-1], axis=1)

    def _forget(self) -> None:
        rate = self.rate
        if rate is None:
            return  # the length of the buffer depends on it
        oldest = self.next_index - 2 * max(METER_S, self.keep_s) * rate
        if self._from is not None:
            oldest = min(oldest, self._from)
        while len(self._buffer) > 1 and self._buffer[0].first_index + len(self._buffer[0]) <= oldest:
            self._buffer.popleft()
