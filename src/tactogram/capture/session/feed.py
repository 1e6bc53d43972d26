"""A source being read: its blocks of the last while, and what a level meter shows of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.session.take import Take, joined, rate_of
from tactogram.capture.session.take_checks import level
from tactogram.capture.source import Block, Source, SourceLost
from tactogram.errors import DataError

METER_S = 0.25
"""What a level meter looks at: the last quarter of a second, as long as a glance."""

MEASURED_S = 0.5
"""How often the measured rate is looked at."""


@dataclass(frozen=True)
class MeterReading:
    """Reading of a level meter.

    Parameters
    ----------
    rms : float
        Of the last `METER_S`, about the mean, root of the sum of squares over axes, source's unit.
    peak : float
        Largest magnitude of any axis, gravity and offsets included: it is what clips.
    full_scale : float or None
        Where the sensor clips.
    clipped : bool
        Whether ``peak`` reached it.
    lost : int
        Samples lost since the source was opened.
    rate : float or None
        Measured, Hz.
    """

    rms: float
    peak: float
    full_scale: float | None
    clipped: bool
    lost: int
    rate: float | None


class Feed:
    """Reads a source and keeps what may be needed.

    Parameters
    ----------
    source : Source
        Open.
    reference_rate : float, optional
        What the rate should be, Hz; by default what the source says.
    full_scale : float, optional
        Where it clips; by default what the source says, if it says so.
    silence_s : float
        How long nothing may come before the source counts as lost.
    clock : callable
        As ``time.monotonic``.
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
        said = getattr(source, "full_scale", None)
        self.full_scale = full_scale if full_scale is not None else said
        self.lost = 0
        """Samples lost so far."""
        self.next_index = 0
        """Place of the sample that comes next."""
        self._silence_s, self._clock = silence_s, clock
        self._last_came = clock()
        self._kept: deque[Block] = deque()
        self._from: int | None = None
        self.keep_s = METER_S
        """How much of the past is kept besides, s."""
        self.first_arrival_s = float("nan")
        """When the first block came."""
        self._measured: Mapping[str, float] | None = None
        self._measured_at = -1

    @property
    def reference_rate(self) -> float | None:
        """What the rate should be, Hz."""
        return self._reference if self._reference is not None else self.source.rate

    @reference_rate.setter
    def reference_rate(self, rate: float | None) -> None:
        self._reference = rate

    @property
    def measured_rate(self) -> Mapping[str, float] | None:
        """What the source measured: ``hz``, ``low``, ``high``; None while unknown."""
        # A robust line through hundreds of arrivals is no thing to ask for at every glance at the meter.
        if self.next_index != self._measured_at and (
            self._measured is None or self.next_index >= self._measured_at + MEASURED_S * self._measured["hz"]
        ):
            self._measured = self.source.facts().get("rate") or None
            self._measured_at = self.next_index
        return self._measured

    @property
    def rate(self) -> float | None:
        """What a take would be written with, Hz; None while unknown."""
        return rate_of(self.measured_rate, self.reference_rate)

    def poll(self, timeout_s: float = 0.1, *, patient: bool = False) -> Block | None:
        """Read one block, or None if none came in time; ``patient`` where it does not matter how long nothing comes.

        Raises
        ------
        SourceEnded, SourceLost
            As `Source.read`; also `SourceLost` when nothing came for ``silence_s``.
        """
        block = self.source.read(timeout_s)
        now = self._clock()
        if block is None:
            silent = now - self._last_came
            if patient:
                self._last_came = now
            elif silent > self._silence_s:
                raise SourceLost(
                    f"{self.source.name}: nothing came for {silent:.1f} s; is it switched on, and in reach?"
                )
            return None
        self._last_came = now
        if not self.next_index:
            self.first_arrival_s = block.arrival_s
        self._kept.append(block)
        self.lost += block.lost
        self.next_index = block.first_index + len(block)
        self._forget()
        return block

    def mark(self) -> int:
        """Keep everything from the next sample on, and return its place."""
        self._from = self.next_index
        return self.next_index

    def take(self, start: int, stop: int) -> Take:
        """Return samples ``start`` to ``stop`` (exclusive), which must have been kept since `mark`.

        Raises
        ------
        DataError
            If nothing came, or the rate is not known yet.
        """
        self._measured, self._measured_at = None, -1
        measured, rate = self.measured_rate, self.rate
        if rate is None:
            raise DataError(f"{self.source.name}: the rate is not known yet; let it run for some seconds")
        samples = joined(self._kept, start=start, stop=stop)
        hz = None if measured is None else measured["hz"]
        return Take(samples, self.source.axes, self.source.unit, rate, hz, start)

    def release(self) -> None:
        """Keep no more than the meter needs."""
        self._from = None
        self._forget()

    def levels(self) -> MeterReading:
        """Return what a level meter shows."""
        recent = self.recent(METER_S)
        came = recent[:, np.isfinite(recent).all(axis=0)]
        peak = float(np.abs(came).max()) if came.size else 0.0
        clipped = self.full_scale is not None and peak >= 0.999 * self.full_scale
        measured = self.measured_rate
        hz = None if measured is None else measured["hz"]
        return MeterReading(level(recent), peak, self.full_scale, clipped, self.lost, hz)

    def recent(self, seconds: float) -> NDArray[np.float32]:
        """Return what came last, float32, (axis, time), NaN where it was lost; no samples while the rate is unknown."""
        rate = self.rate
        count = 0 if rate is None else round(seconds * rate)
        parts: list[NDArray[np.float32]] = []
        for block in reversed(self._kept):
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
            # Until it is known, nobody can say how much that is.
            return
        oldest = self.next_index - 2 * max(METER_S, self.keep_s) * rate
        if self._from is not None:
            oldest = min(oldest, self._from)
        while len(self._kept) > 1 and self._kept[0].first_index + len(self._kept[0]) <= oldest:
            self._kept.popleft()
