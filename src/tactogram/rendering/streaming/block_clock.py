"""Block clock: regular start times of blocks that a device requests irregularly.

A device plays its samples evenly but requests them when its buffers and the machine's load allow: some milliseconds
early or late. A finger sampled at those moments would seem to tremble, felt as a rough pitch. A delay-locked loop of
second order (F. Adriaensen, "Using a DLL to filter time", Linux Audio Conference 2005) recovers the regular start
times.
"""

from __future__ import annotations

import math

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
