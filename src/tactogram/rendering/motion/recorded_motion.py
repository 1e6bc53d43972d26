"""Motion of a file and of a simulated hand."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.motion.finger_state import MotionSample
from tactogram.text_files import csv_rows, read_text

COLUMNS = ("time_s", "x_mm", "y_mm", "speed_mm_s", "force_n")
"""Columns of a motion file: the first and at least one other are required. An empty cell is a missing value."""

DENSE_S = 0.005
"""Longest time between two samples of a dense motion, s."""
Array = NDArray[np.float64]
UP_S = 0.08
"""Time in which a finger lifts before it moves on, or comes down, s."""
POSITION_RATE, FORCE_RATE = 250.0, 500.0
"""Rates of the two sensors, Hz."""
LENGTH_MM, DURATION_S = (40.0, 120.0), (0.4, 1.2)
"""Of a stroke, which follows the path of least jerk (Flash & Hogan 1985): from rest to rest, its peak speed 1.875 times
its mean."""
REST_S, LIFT_S, STROKES_BETWEEN_LIFTS = (0.02, 0.25), (0.15, 0.5), 3
"""Every few strokes the finger lifts and lands elsewhere."""
FORCE_N = 0.6
"""Mean normal force while touching, which varies by about a third."""


class MotionFile:
    """Motion from a CSV with `COLUMNS` in any order, at the ascending times in ``time_s``; ``y_mm`` is 0 if omitted.

    Raises `DataError` naming file and line if the file is invalid.
    """

    simulated = False

    def __init__(self, path: Path | str) -> None:
        self.samples = list(_rows(Path(path)))
        self.name = Path(path).name
        self._next = 0
        self._offset = -self.samples[0].time_s

    @property
    def seconds(self) -> float:
        """Time from the first sample to the last, s."""
        return self.samples[-1].time_s - self.samples[0].time_s

    def fill(self, seconds: float) -> None:
        """Interpolate linearly what is missing in the first ``seconds``: no gap then counts as a lost connection.

        The samples are then at most `DENSE_S` apart, with every value that any of them had.
        """
        recorded = np.array([sample.time_s for sample in self.samples])
        end_s = recorded[0] + seconds
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
            values = np.array([getattr(sample, name) for sample in self.samples])
            if (known := np.isfinite(values)).any():
                columns[name] = np.interp(dense, recorded[known], values[known]).tolist()
        self.samples = [
            MotionSample(time_s, time_s, **{name: values[k] for name, values in columns.items()})
            for k, time_s in enumerate(dense.tolist())
        ]

    def poll(self, now_s: float) -> list[MotionSample]:
        """Return the next samples up to ``now_s``; the first sample is at 0."""
        samples = []
        while self._next < len(self.samples):
            sample = self.samples[self._next]
            time_s = sample.time_s + self._offset
            if time_s > now_s:
                break
            samples.append(replace(sample, time_s=time_s, arrival_s=time_s))
            self._next += 1
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
        time_s = values.pop("time_s")
        if not (math.isfinite(time_s) and time_s > last):
            raise DataError(
                f"{path}: line {number}: times must ascend and be finite, got {time_s:g} after {last:g}"
            )
        if (
            any(math.isinf(v) for v in values.values())
            or min(values.get("speed_mm_s", 0), values.get("force_n", 0)) < 0
        ):
            raise DataError(f"{path}: line {number}: speed and force must be finite and >= 0, got {row}")
        last = time_s
        if not math.isnan(values.get("x_mm", math.nan)):
            values.setdefault("y_mm", 0.0)
        yield MotionSample(time_s, time_s, **values)


class SimulatedHand:
    """Motion of a simulated hand for ``seconds``; the same seed gives the same motion.

    ``noise_mm`` is the standard deviation of a position.
    """

    name = "simulated hand"
    simulated = True

    def __init__(self, seconds: float, *, seed: int, noise_mm: float = 0.01) -> None:
        if not (seconds > 0 and math.isfinite(seconds)):
            raise ParameterError.must("seconds", "be > 0", seconds)
        random = np.random.default_rng(seed)
        knots = _journey(seconds, random)
        at_position = np.arange(math.ceil(seconds * POSITION_RATE)) / POSITION_RATE
        x, y, _ = _along(knots, at_position)
        x += noise_mm * random.standard_normal(len(x))
        y += noise_mm * random.standard_normal(len(y))
        # Half an interval apart, like two independent sensors.
        at_force = np.asarray((np.arange(math.ceil(seconds * FORCE_RATE)) + 0.5) / FORCE_RATE, np.float64)
        force = _force(knots, at_force, random)
        times = np.concatenate((at_position, at_force))
        order = np.argsort(times, kind="stable")
        nothing = np.full(len(at_force), math.nan)
        self._times = times[order]
        self._x = np.concatenate((x, nothing))[order]
        self._y = np.concatenate((y, nothing))[order]
        self._force = np.concatenate((np.full(len(at_position), math.nan), force))[order]
        self._next = 0

    def poll(self, now_s: float) -> list[MotionSample]:
        """Return the motion since the last call up to ``now_s``, without delay."""
        end = int(np.searchsorted(self._times, now_s, side="right"))
        begin, self._next = self._next, max(self._next, end)
        return [
            MotionSample(t, t, x, y, math.nan, force)
            for t, x, y, force in zip(
                self._times[begin:end].tolist(),
                self._x[begin:end].tolist(),
                self._y[begin:end].tolist(),
                self._force[begin:end].tolist(),
                strict=True,
            )
        ]

    def close(self) -> None:
        """Do nothing."""


@dataclass(frozen=True)
class _HandMove:
    begin_s: float
    end_s: float
    start: tuple[float, float]
    stop: tuple[float, float]
    touching: bool


def _journey(seconds: float, random: np.random.Generator) -> list[_HandMove]:
    """Return consecutive moves that last at least ``seconds``."""
    moves: list[_HandMove] = []
    now, position, direction = 0.0, (0.0, 0.0), 1.0

    def go(lasting: float, to: tuple[float, float], *, touching: bool) -> None:
        nonlocal now, position
        moves.append(_HandMove(now, now + lasting, position, to, touching))
        now, position = now + lasting, to

    go(0.2, position, touching=False)
    while now < seconds:
        strokes = 1 + random.poisson(STROKES_BETWEEN_LIFTS - 1)
        go(random.uniform(*REST_S), position, touching=True)
        for _ in range(strokes):
            length = random.uniform(*LENGTH_MM)
            to = (position[0] + direction * length, position[1] + random.normal(0, 0.05 * length))
            go(random.uniform(*DURATION_S), to, touching=True)
            go(random.uniform(*REST_S), position, touching=True)
            direction = -direction
        landing = (position[0] + random.uniform(-30, 30), position[1] + random.uniform(-30, 30))
        go(UP_S, position, touching=False)
        go(random.uniform(*LIFT_S), landing, touching=False)
        go(UP_S, landing, touching=False)
    return moves


def _along(moves: list[_HandMove], times: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return x, y (mm) and whether the finger touches, at ``times`` (s)."""
    index = np.searchsorted([move.end_s for move in moves], times, side="right")
    begin, end = (np.array([getattr(m, name) for m in moves])[index] for name in ("begin_s", "end_s"))
    start, stop = (np.array([getattr(m, name) for m in moves])[index] for name in ("start", "stop"))
    share = np.clip((times - begin) / (end - begin), 0, 1)
    progress = share**3 * (10 - 15 * share + 6 * share**2)
    position = start + progress[:, None] * (stop - start)
    touching = np.array([m.touching for m in moves])[index]
    return position[:, 0], position[:, 1], touching


def _force(moves: list[_HandMove], times: Array, random: np.random.Generator) -> Array:
    """Return the force at ``times``, N: 0 in the air, slowly varying on the surface, rising and falling fast."""
    _, _, touching = _along(moves, times)
    slow = np.zeros(len(times))
    for hz in (0.3, 0.7, 1.9):
        slow += np.sin(2 * np.pi * (hz * times + random.uniform())) / 3
    target = np.where(touching, FORCE_N * (1 + 0.6 * slow), 0.0)
    decay = math.exp(-1 / (0.012 * FORCE_RATE))
    smooth = scipy.signal.lfilter([1 - decay], [1, -decay], target)
    return np.where(smooth < 0.01, 0.0, smooth)
