"""A computer mouse as a finger, on Linux."""

from __future__ import annotations

import math
import os
from pathlib import Path

from tactogram.errors import DeviceError, ParameterError, one_line
from tactogram.rendering import MotionSample

MICE = Path("/dev/input/mice")
"""Linux's device for the movements of all mice, three bytes each (PS/2): buttons and signs, right, up."""


class MouseMotion:
    """A mouse on Linux as a finger, which touches with ``force_n`` while the left button is down.

    It is read once per block, so a position may be late by up to one block plus the mouse's own interval (8 ms at 125
    Hz). 31.5 counts per mm are 800 per inch. Raises `DeviceError` if there is no such device or it may not be read.
    """

    simulated = False

    def __init__(self, *, counts_per_mm: float = 31.5, force_n: float = 0.5, path: Path = MICE) -> None:
        if not (counts_per_mm > 0 and math.isfinite(counts_per_mm)):
            raise ParameterError.must("counts_per_mm", "be > 0 and finite", counts_per_mm)
        self.name = f"mouse:{path}"
        self._per_mm, self._force = counts_per_mm, force_n
        self._x = self._y = 0.0
        self._down = False
        self._rest = b""
        try:
            self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            raise DeviceError(
                f"{self.name}: cannot be read ({one_line(error)}); a mouse needs Linux, and the group input or root"
            ) from error

    def poll(self, now_s: float) -> list[MotionSample]:
        """Return the current position, even without movement, so that the connection does not count as lost."""
        while True:
            try:
                read = os.read(self._file, 3 * 64)
            except BlockingIOError:
                break
            except OSError:
                return []
            if not read:
                break
            data = self._rest + read
            whole = len(data) - len(data) % 3
            self._rest = data[whole:]
            for start in range(0, whole, 3):
                self._down, dx, dy = mouse_step(data[start : start + 3])
                self._x += dx / self._per_mm
                self._y += dy / self._per_mm
        return [MotionSample(now_s, now_s, self._x, self._y, math.nan, self._force if self._down else 0.0)]

    def close(self) -> None:
        """Close the device."""
        os.close(self._file)


def mouse_step(packet: bytes) -> tuple[bool, int, int]:
    """Return whether the left button is down, and the counts right and up, from a PS/2 packet of three bytes."""
    head, right, up = packet
    return bool(head & 1), right - (256 if head & 0x10 else 0), up - (256 if head & 0x20 else 0)
