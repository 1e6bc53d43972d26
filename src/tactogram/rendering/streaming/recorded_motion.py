"""Motion from a file and from a computer mouse."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from tactogram.errors import DataError, DeviceError, ParameterError, one_line
from tactogram.rendering.streaming.motion import MotionSample
from tactogram.text_files import csv_rows, read_text

COLUMNS = ("time_s", "x_mm", "y_mm", "speed_mm_s", "force_n")
"""Columns of a motion file: the first and at least one other are required. An empty cell is a missing value."""

DENSE_S = 0.005
"""Longest time between two samples of a dense motion, s."""
MICE = Path("/dev/input/mice")
"""Linux's device for the movements of all mice, three bytes each (PS/2): buttons and signs, right, up."""


class MotionFile:
    """Motion from a CSV with `COLUMNS` in any order, at the ascending times in ``time_s``; ``y_mm`` is 0 if omitted.

    A ``loop`` restarts at the end, lifted for a moment, instead of falling silent. Raises `DataError` naming file and
    line if the file is invalid.
    """

    simulated = False

    def __init__(self, path: Path | str, *, loop: bool = False) -> None:
        self.samples = list(_rows(Path(path)))
        self.name = Path(path).name
        self._loop = loop
        self._next = 0
        self._offset = -self.samples[0].time_s

    @property
    def seconds(self) -> float:
        """Time from the first sample to the last, s."""
        return self.samples[-1].time_s - self.samples[0].time_s

    def fill(self, seconds: float) -> None:
        """Interpolate linearly what is missing in the first ``seconds``: no gap then counts as a lost connection."""
        self.samples = _dense(self.samples, self.samples[0].time_s + seconds)

    def poll(self, now_s: float) -> list[MotionSample]:
        """Return the next samples up to ``now_s``; the first sample is at 0."""
        samples = []
        while self._next < len(self.samples):
            sample = self.samples[self._next]
            at = sample.time_s + self._offset
            if at > now_s:
                break
            samples.append(replace(sample, time_s=at, arrival_s=at))
            self._next += 1
            if self._next == len(self.samples) and self._loop and self.seconds > 0:
                self._next = 0
                self._offset += self.seconds + 1e-3
        return samples

    def close(self) -> None:
        """Do nothing: the file is already closed."""


def _rows(path: Path) -> Iterator[MotionSample]:
    rows = [(n, row) for n, row in csv_rows(read_text(path), path) if not row[0].startswith("#")]
    heading = [cell.strip() for cell in rows[0][1]] if rows else []
    if "time_s" not in heading or not set(heading) <= set(COLUMNS) or len(heading) < 2:
        raise DataError(f"{path}: line 1: expected columns of {', '.join(COLUMNS)}, got {', '.join(heading)}")
    if "y_mm" in heading and "x_mm" not in heading:
        raise DataError(f"{path}: line 1: y_mm needs x_mm")
    if len(rows) < 2:
        raise DataError(f"{path}: no motion after the heading")
    last = -math.inf
    for number, row in rows[1:]:
        try:
            values = {
                name: float(cell) if cell.strip() else math.nan
                for name, cell in zip(heading, row, strict=True)
            }
        except ValueError:
            raise DataError(f"{path}: line {number}: expected {len(heading)} numbers, got {row}") from None
        at = values.pop("time_s")
        if not (math.isfinite(at) and at > last):
            raise DataError(
                f"{path}: line {number}: times must ascend and be finite, got {at:g} after {last:g}"
            )
        if (
            any(math.isinf(v) for v in values.values())
            or min(values.get("speed_mm_s", 0), values.get("force_n", 0)) < 0
        ):
            raise DataError(f"{path}: line {number}: speed and force must be finite and >= 0, got {row}")
        last = at
        if not math.isnan(values.get("x_mm", math.nan)):
            values.setdefault("y_mm", 0.0)
        yield MotionSample(at, at, **values)


def _dense(samples: list[MotionSample], end_s: float) -> list[MotionSample]:
    """Return samples at most `DENSE_S` apart, up to ``end_s``, with every value that any sample has."""
    recorded = np.array([sample.time_s for sample in samples])
    times = np.append(recorded[recorded < end_s], end_s)
    counts = np.ceil(np.diff(times) / DENSE_S).astype(int)
    dense = np.concatenate(
        [
            np.linspace(*ends, count, endpoint=False)
            for ends, count in zip(pairwise(times), counts, strict=True)
        ]
        + [times[-1:]]
    )
    columns: dict[str, list[float]] = {}
    for name in COLUMNS[1:]:
        values = np.array([getattr(sample, name) for sample in samples])
        if (known := np.isfinite(values)).any():
            columns[name] = np.interp(dense, recorded[known], values[known]).tolist()
    return [
        MotionSample(at, at, **{name: values[k] for name, values in columns.items()})
        for k, at in enumerate(dense.tolist())
    ]


class MouseMotion:
    """A mouse on Linux as a finger, which touches with ``force_n`` while the left button is down.

    It is read once per block, so a position may be late by up to one block plus the mouse's own interval (8 ms at 125
    Hz). 31.5 counts per mm are 800 per inch. Raises `DeviceError` if there is no such device or it may not be read.
    """

    simulated = False

    def __init__(self, *, counts_per_mm: float = 31.5, force_n: float = 0.5, path: Path = MICE) -> None:
        if not (counts_per_mm > 0 and math.isfinite(counts_per_mm)):
            raise ParameterError(f"counts_per_mm must be > 0 and finite, got {counts_per_mm}")
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
            for place in range(0, whole, 3):
                self._down, dx, dy = mouse_step(data[place : place + 3])
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
