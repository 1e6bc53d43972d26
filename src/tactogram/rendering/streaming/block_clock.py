"""Block clock: start times on the samples' own clock, however unevenly a device asks for blocks.

A device plays its samples evenly and asks for them when its buffers and the machine's other work let it: some
milliseconds early or late. A finger that is asked for at those moments seems to tremble, which is felt as a rough
pitch. A delay-locked loop of second order (F. Adriaensen, "Using a DLL to filter time", Linux Audio Conference 2005)
tells the even beginnings from the uneven requests.
"""

from __future__ import annotations

import math

BANDWIDTH_HZ = 0.2
"""What is slower than this is the device's clock, what is faster its unevenness."""
LOCKING_S = 1.0
"""At the beginning the loop is quicker, for so long."""
LOST_S = 0.05
"""A request so far off is a device that stood still: begin anew, s."""


class BlockClock:
    """A delay-locked loop over the beginnings of blocks; times in s."""

    def __init__(self) -> None:
        self._next = math.nan
        self._drift = 0.0
        self._age = 0.0

    def begins(self, asked_s: float, length_s: float) -> float:
        """Return when the block that was asked for at ``asked_s`` begins; it lasts ``length_s``."""
        missed = asked_s - self._next
        if not abs(missed) <= LOST_S:
            self._next, self._drift, self._age, missed = asked_s, 0.0, 0.0, 0.0
        bandwidth = BANDWIDTH_HZ * (1 + 19 * max(0.0, 1 - self._age / LOCKING_S))
        omega = min(2 * math.pi * bandwidth * length_s, 0.5)
        begin = self._next + math.sqrt(2) * omega * missed
        self._drift += omega * omega * missed
        self._next = begin + length_s + self._drift
        self._age += length_s
        return begin
