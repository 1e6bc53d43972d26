"""Source for boards that print a line of numbers per sample: Arduino, Teensy and others."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.capture.source import Block
from tactogram.capture.stream.byte_source import ByteSource
from tactogram.capture.stream.byte_stream import ByteStream
from tactogram.capture.stream.channels import axis_names, described_axes, source_facts
from tactogram.capture.stream.csv_lines import CsvParser
from tactogram.capture.stream.rate_estimate import RateEstimate, RateMeter
from tactogram.errors import ParameterError, UnitError
from tactogram.signal.units import parse_seconds, parse_unit, split_heading

TIME_NAMES = {
    "t": "s", "time": "s", "timestamp": "us", "s": "s", "sec": "s", "seconds": "s", "ms": "ms", "millis": "ms",
    "us": "us", "micros": "us",
}  # fmt: skip
"""Headings of time columns, and their units where the heading gives none. A ``timestamp`` without a unit is in
microseconds, as most boards print it."""
RATE_ROWS = 32
"""Rows whose median step gives the nominal period, if no rate is given."""
MOST_MISSING = 2_000_000
"""Most samples inserted for one jump of the time column."""
MOST_UNCONFIRMED = 100
"""Rows that the time may skip without a second row to confirm it; a longer jump may be a damaged digit."""

_LARGEST = float(np.finfo(np.float32).max)


class CsvFormat(BaseModel):
    """Format of a board's lines; by default it is detected from the lines."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    time: str | None = None
    """Name or number (from 1) of the board's time column; ``"none"`` if there is none. By default the column
    with a heading of `TIME_NAMES`."""
    time_unit: Literal["s", "ms", "us"] | None = None
    """Unit of the time, if the heading has none."""
    unit: str | None = None
    """Unit of the samples: m/s^2, g, mg, V, mV, N, …; by default the heading's, or 1 for counts."""
    scale: float = Field(default=1.0, allow_inf_nan=False)
    """Factor from the printed numbers to that unit."""
    rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Nominal rate, Hz; by default learnt from the board's time."""
    axes: str | None = None
    """Names of the columns other than the time, separated by commas; by default the heading's, or x, y, z."""


class CsvSource(ByteSource):
    """A board that prints a line per sample; see `tactogram.capture.source.Source`.

    The board's time column reveals lost samples, and NaN takes their place. Without one, only damaged lines are
    noticed: each counts as one lost sample. ``name`` is the address, ``log`` a new file for all bytes.
    """

    def __init__(
        self,
        stream: ByteStream,
        form: CsvFormat,
        *,
        name: str,
        log: Path | str | None = None,
        simulated: bool = False,
    ) -> None:
        super().__init__(stream, name=name, kind="serial", log=log, simulated=simulated)
        self.form = form
        self.parser = CsvParser()
        self.rate = form.rate
        self.unit, factor = ("1", 1.0) if form.unit is None else parse_unit(form.unit)
        self._factor = factor * form.scale
        self.axes: tuple[str, ...] = tuple(a.strip() for a in form.axes.split(",")) if form.axes else ()
        self.meter = RateMeter()
        self.received = self.lost = self.clock_restarts = 0
        self._time: int | None = None
        self._tick_s = 1.0
        self._last_s: float | None = None
        self._ticks = _CounterUnwrapper()
        self._suspect: list[float] | None = None
        """A row whose time jumps, until the next row confirms it."""
        self._unplaced: list[list[float]] = []
        """Timed rows, until the rate is known."""
        self._next = 0
        self._columns_named = False

    def facts(self) -> dict[str, Any]:
        """Return the facts so far."""
        return source_facts(
            self.meter,
            samples=self.received,
            lost=self.lost,
            simulated=self.simulated,
            rejected=dict(self.parser.rejected),
            before=self.parser.before,
            comments=self.parser.comments,
            losses_seen=self._time is not None,
            time_went_back=self.clock_restarts,
        )

    def estimate(self) -> RateEstimate | None:
        """Return the measured rate, from the board's time if it prints one, else from arrival times."""
        return self.meter.estimate()

    def _parse(self, data: bytes, arrival_s: float) -> Block | None:
        return self._block(self.parser.feed(data), arrival_s)

    def _finish(self) -> Block | None:
        self.parser.finish()
        return self._block([], float("nan"), last=True)

    def _block(self, rows: list[list[float] | None], arrival: float, *, last: bool = False) -> Block | None:
        if not self._columns_named and self.parser.columns:
            self._name_columns()
        columns: list[NDArray[np.float64]] = []
        first = self._next
        for row in rows:
            if row is None:
                if self._time is None and self._columns_named:
                    columns.append(self._gap(1))
            elif self._time is None:
                columns.append(self._sample(row))
            elif math.isfinite(row[self._time]):
                self._unplaced.append(row)
            else:
                self.parser.rejected["time"] += 1
        if self._time is not None and self._rate_known(last):
            for row in self._unplaced:
                columns += self._timed(row)
            self._unplaced = []
        if last and self._suspect is not None:
            self._reject_suspect()
        if not columns:
            return None
        if self._time is None:
            self.meter.add(self._next, arrival)
        return Block(np.concatenate(columns, axis=1).astype(np.float32), first, arrival)

    def _rate_known(self, last: bool) -> bool:
        """Learn the nominal rate from the times of the first rows, if it was not given."""
        if self.rate is None and self._unplaced and (len(self._unplaced) >= RATE_ROWS or last):
            ticks = [row[self._time or 0] for row in self._unplaced]
            steps = [b - a for a, b in pairwise(ticks) if b > a]
            if steps:
                self.rate = 1 / (float(np.median(steps)) * self._tick_s)
        return self.rate is not None or last

    def _timed(self, row: list[float]) -> list[NDArray[np.float64]]:
        """Return the samples that a row adds: none while its time jumps and no second row confirms it."""
        if self._suspect is not None:
            if self._follows(row, self._seconds(self._suspect)):
                suspect, self._suspect = self._suspect, None
                return [*self._placed(suspect), *self._placed(row)]
            self._reject_suspect()
        if self._last_s is not None and self.rate is not None and not self._follows(row, self._last_s):
            self._suspect = row
            return []
        return self._placed(row)

    def _seconds(self, row: list[float]) -> float:
        return self._ticks.peek(row[self._time or 0]) * self._tick_s

    def _follows(self, row: list[float], before_s: float) -> bool:
        return 0 <= (self._seconds(row) - before_s) * (self.rate or 0.0) <= MOST_UNCONFIRMED

    def _reject_suspect(self) -> None:
        self._suspect = None
        self.parser.rejected["stray time"] += 1

    def _placed(self, row: list[float]) -> list[NDArray[np.float64]]:
        """Return a row as a sample, after as many NaN as the board's time skipped."""
        seconds = self._ticks.add(row[self._time or 0]) * self._tick_s
        placed: list[NDArray[np.float64]] = []
        if self._last_s is not None and self.rate is not None:
            step = seconds - self._last_s
            if step < 0:
                # The board restarted; its clock began anew, and the duration of the gap is unknown.
                self.clock_restarts += 1
                self.meter.restart()
                placed.append(self._gap(1))
            elif (missing := round(min(step * self.rate, MOST_MISSING)) - 1) > 0:
                placed.append(self._gap(missing))
        placed.append(self._sample(row))
        self._last_s = seconds
        self.meter.add(self._next, seconds)
        return placed

    def _gap(self, count: int) -> NDArray[np.float64]:
        return self._counted(np.full((len(self.axes), count), np.nan))

    def _sample(self, row: list[float]) -> NDArray[np.float64]:
        values = [value for place, value in enumerate(row) if place != self._time]
        column = np.array(values)[:, None] * self._factor
        # A sample is valid in all axes or lost; values beyond float32 are not measurements.
        valid = (np.abs(column) <= _LARGEST).all()
        return self._counted(column if valid else np.full_like(column, np.nan))

    def _counted(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        lost = int(np.isnan(samples).any(axis=0).sum())
        self._next += samples.shape[1]
        self.lost += lost
        self.received += samples.shape[1] - lost
        return samples

    def _name_columns(self) -> None:
        """Choose the time column, and name the others with their unit, at the first row."""
        headings = [split_heading(name) for name in self.parser.headings]
        names = [name for name, _ in headings]
        self._time = self._time_column(names)
        self._columns_named = True
        if self._time is not None:
            by_heading = headings[self._time][1] if headings else None
            by_name = TIME_NAMES.get(names[self._time].lower() if names else "", "us")
            unit = self.form.time_unit or by_heading or by_name
            seconds = parse_seconds(unit)
            if seconds is None:
                raise ParameterError(f"time_unit must be s, ms or us, got {unit!r}")
            self._tick_s = seconds
        width = self.parser.columns - (self._time is not None)
        if not width:
            raise ParameterError(f"{self.name}: the lines contain only a time")
        data = [heading for place, heading in enumerate(headings) if place != self._time]
        if self.form.axes:
            self.axes = axis_names(width, self.form.axes, where=self.name)
        else:
            self.axes = described_axes(width, [name for name, _ in data])
        units = {unit for _, unit in data if unit}
        if self.form.unit is None and len(units) == 1:
            try:
                self.unit, factor = parse_unit(units.pop())
            except UnitError:
                return
            self._factor *= factor

    def _time_column(self, names: list[str]) -> int | None:
        wanted = self.form.time
        if wanted == "none":
            return None
        if wanted is None:
            places = [place for place, name in enumerate(names) if name.lower() in TIME_NAMES]
            return places[0] if len(places) == 1 else None
        if wanted in names:
            return names.index(wanted)
        if wanted.isdigit() and 1 <= int(wanted) <= self.parser.columns:
            return int(wanted) - 1
        columns = ", ".join(names) or f"1 to {self.parser.columns}"
        raise ParameterError(
            f"{self.name}: time must be one of the columns {columns}, or none, got {wanted!r}"
        )


class _CounterUnwrapper:
    """A 32-bit counter that continues: micros() starts again after 71 minutes."""

    def __init__(self) -> None:
        self._turns, self._last = 0.0, -math.inf

    def peek(self, ticks: float) -> float:
        turns = self._turns
        if self._last - ticks > 2**31 and self._last < 2**32:
            turns += 2**32
        return turns + ticks

    def add(self, ticks: float) -> float:
        total = self.peek(ticks)
        self._turns, self._last = total - ticks, ticks
        return total
