"""Timing of a stream: regular start times of blocks, and statistics of its latency.

A device plays its samples evenly but requests them when its buffers and the machine's load allow: some milliseconds
early or late. A finger sampled at those moments would seem to tremble, felt as a rough pitch. A delay-locked loop of
second order (F. Adriaensen, "Using a DLL to filter time", Linux Audio Conference 2005) recovers the regular start
times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

BANDWIDTH_HZ = 0.2
"""Slower variations are the device's clock, faster ones its jitter."""
LOCKING_S = 1.0
"""The loop is faster for this long at the beginning, s."""
LOST_S = 0.05
"""An error this large means that the device paused: the loop restarts, s."""


class BlockClock:
    """Delay-locked loop over the start times of blocks, s."""

    def __init__(self) -> None:
        self._next = math.nan
        self._drift = 0.0
        self._age = 0.0

    def start_of(self, requested_s: float, length_s: float) -> float:
        """Return the start time of a block of ``length_s`` that was requested at ``requested_s``."""
        error = requested_s - self._next
        if not abs(error) <= LOST_S:
            self._next, self._drift, self._age, error = requested_s, 0.0, 0.0, 0.0
        bandwidth = BANDWIDTH_HZ * (1 + 19 * max(0.0, 1 - self._age / LOCKING_S))
        omega = min(2 * math.pi * bandwidth * length_s, 0.5)
        start = self._next + math.sqrt(2) * omega * error
        self._drift += omega * omega * error
        self._next = start + length_s + self._drift
        self._age += length_s
        return start


SHORTEST_S = 1e-7
PER_DECADE = 232
"""Bins per factor of ten: each is 1 % wide."""
DECADES = 9


class Durations:
    """Histogram of durations in bins 1 % wide from 0.1 µs to 100 s, without allocations."""

    def __init__(self) -> None:
        self._counts: NDArray[np.int64] = np.zeros(PER_DECADE * DECADES + 2, np.int64)
        self.count = 0
        self.longest_s = 0.0
        self._sum = 0.0

    def add(self, seconds: float) -> None:
        """Count a duration."""
        index = int(PER_DECADE * math.log10(seconds / SHORTEST_S)) + 1 if seconds > SHORTEST_S else 0
        self._counts[min(index, len(self._counts) - 1)] += 1
        self.count += 1
        self._sum += seconds
        self.longest_s = max(self.longest_s, seconds)

    def quantile(self, share: float) -> float:
        """Return the duration that ``share`` of all do not exceed, s, at most 1 % too long; NaN if there are none."""
        if self.count == 0:
            return math.nan
        reached = np.cumsum(self._counts)
        index = int(np.searchsorted(reached, share * self.count))
        return min(self.longest_s, SHORTEST_S * 10 ** (index / PER_DECADE))

    def facts(self) -> dict[str, float | int | None]:
        """Return ``p50_ms``, ``p99_ms``, ``max_ms`` and ``mean_ms``, None if there are none, and ``count``."""
        seconds = (self.quantile(0.5), self.quantile(0.99), self.longest_s, self._sum / max(1, self.count))
        names = ("p50_ms", "p99_ms", "max_ms", "mean_ms")
        known = {name: 1e3 * time if self.count else None for name, time in zip(names, seconds, strict=True)}
        return {**known, "count": self.count}


@dataclass
class Latency:
    """Latency statistics of a stream, per block.

    ``compute`` is wall time, ``processor`` the thread's processor time: the difference is other programs' share.

    ``total`` is the time from the newest motion (by its time stamp) to the end of the block that used it: its age when
    the block began, the time to compute the block, the backend's queue (``queued_s``, as the backend reports it, else
    0), and the block itself. It does not include the display's own latency and the network's minimum delay, which
    cannot be measured here.
    """

    block_s: float
    queued_s: float = 0.0
    compute: Durations = field(default_factory=Durations)
    processor: Durations = field(default_factory=Durations)
    age: Durations = field(default_factory=Durations)
    tap: Durations = field(default_factory=Durations)
    total: Durations = field(default_factory=Durations)
    underruns: int = 0

    def add(self, compute_s: float, processor_s: float, age_s: float, *, block_s: float) -> None:
        """Count a block by its wall time and processor time; ``age_s`` is inf without motion."""
        self.compute.add(compute_s)
        self.processor.add(processor_s)
        if age_s < math.inf:
            self.age.add(max(age_s, 0.0))
            self.total.add(max(age_s, 0.0) + compute_s + self.queued_s + block_s)

    def facts(self) -> dict[str, Any]:
        """Return JSON values: ``underruns``, and the five durations by name as `Durations.facts`."""
        return {
            "block_ms": 1e3 * self.block_s,
            "queued_ms": 1e3 * self.queued_s,
            **{name: getattr(self, name).facts() for name in ("compute", "processor", "age", "tap", "total")},
            "underruns": self.underruns,
        }
