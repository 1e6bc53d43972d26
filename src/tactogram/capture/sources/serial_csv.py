"""Boards that print a line of numbers per sample: Arduino, Teensy and their kin."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from tactogram.capture.source import Block, SourceEnded
from tactogram.capture.stream.byte_stream import ByteStream
from tactogram.capture.stream.csv_lines import CsvParser
from tactogram.capture.stream.rate_estimate import RateEstimate, RateMeter
from tactogram.capture.stream.raw_log import LoggedStream
from tactogram.errors import ParameterError, UnitError
from tactogram.signal.units import parse_seconds, parse_unit, split_heading

TIME_NAMES = {
    "t": "s", "time": "s", "timestamp": "us", "s": "s", "sec": "s", "seconds": "s", "ms": "ms", "millis": "ms",
    "us": "us", "micros": "us",
}  # fmt: skip
"""Names of a column that is taken for the time, and its unit where the heading gives none. A ``timestamp`` without a
unit is taken for microseconds, which boards print."""
LEARNT_ROWS = 32
"""Rows whose median step is the nominal period, where none is given."""
MOST_MISSING = 2_000_000
"""Samples that a leap of the time column is entered as at most."""
MOST_UNCONFIRMED = 100
"""Rows that the time may leave out, without another row that says so, too: it may be a damaged digit."""

_LARGEST = float(np.finfo(np.float32).max)


class CsvFormat(BaseModel):
    """Format of a board's lines; what is not given is detected from the lines."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    time: str | None = None
    """Name or place (from 1) of the column with the board's own time; ``"none"`` if there is none. By default the one
    that a heading calls so (`TIME_NAMES`)."""
    time_unit: Literal["s", "ms", "us"] | None = None
    """Unit of that time, where the heading does not say."""
    unit: str | None = None
    """Unit of the samples: m/s^2, g, mg, V, mV, N, …; by default the heading's, or 1, which are counts."""
    scale: float = Field(default=1.0, allow_inf_nan=False)
    """What numbers are multiplied by to be in that unit."""
    rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Nominal rate, Hz; by default learnt from the board's own time."""
    axes: str | None = None
    """Names of the columns without the time, separated by commas; by default the heading's, or x, y, z."""


class CsvSource:
    """A board that prints a line per sample; see `tactogram.capture.source.Source`.

    With a column of the board's own time, losses are seen from it and put in their place. Without one they are not
    seen, except for lines that came damaged: each of those stands for one lost sample.

    Parameters
    ----------
    stream : ByteStream
    form : CsvFormat
    name : str
        The address.
    log : Path, optional
        A new file that all bytes go to.
    simulated : bool
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
        self.name, self.form, self.simulated = name, form, simulated
        self.parser = CsvParser()
        self.rate = form.rate
        self.unit, self._factor = _unit(form.unit)
        self._factor *= form.scale
        self.axes: tuple[str, ...] = tuple(a.strip() for a in form.axes.split(",")) if form.axes else ()
        self.meter = RateMeter()
        self.received = self.lost = self.backward = 0
        if log is not None:
            stream = LoggedStream(stream, log, kind="serial", address=name, simulated=simulated)
        self._stream = stream
        self._time: int | None = None
        self._tick_s = 1.0
        self._last_tick: float | None = None
        self._ticks = _CounterUnwrapper()
        self._held: list[float] | None = None
        self._waiting: list[list[float]] = []
        self._next = 0
        self._over: str | None = None
        self._known = False

    def __enter__(self) -> Self:
        """Open it, and the log first."""
        self._stream.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._stream.__exit__(kind, error, trace)

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return what has come; None if no row did within ``timeout_s``."""
        if self._over is not None:
            raise SourceEnded(self._over)
        until = monotonic() + timeout_s
        while True:
            try:
                got = self._stream.read(max(0.0, until - monotonic()))
            except SourceEnded as end:
                self._over = str(end)
                self.parser.finish()
                block = self._block([], float("nan"), last=True)
                if block is None:
                    raise
                return block
            if got is None:
                return None
            data, arrival = got
            block = self._block(self.parser.feed(data), arrival)
            if block is not None or monotonic() >= until:
                return block

    def facts(self) -> dict[str, Any]:
        """Return what is known."""
        estimate = self.estimate()
        return {
            "samples": self.received,
            "lost": self.lost,
            "rejected": dict(self.parser.rejected),
            "before": self.parser.before,
            "comments": self.parser.comments,
            "losses_seen": self._time is not None,
            "time_went_back": self.backward,
            "rate": None if estimate is None else estimate.facts(),
            "simulated": self.simulated,
        }

    def estimate(self) -> RateEstimate | None:
        """Return the measured rate: by the board's own time if it prints one, else by the times of arrival."""
        return self.meter.estimate()

    def _block(self, rows: list[list[float] | None], arrival: float, *, last: bool = False) -> Block | None:
        if not self._known and self.parser.columns:
            self._name_columns()
        columns: list[NDArray[np.float64]] = []
        first = self._next
        for row in rows:
            if row is None:
                if self._time is None and self._known:
                    columns.append(np.full((len(self.axes), 1), np.nan))
                    self._place(columns[-1])
            elif self._time is None:
                columns.append(self._values(row))
                self._place(columns[-1])
            elif math.isfinite(row[self._time]):
                self._waiting.append(row)
            else:
                self.parser.rejected["time"] += 1
        if self._time is not None and self._ready(last):
            for row in self._waiting:
                columns += self._timed(row)
            self._waiting = []
        if last and self._held is not None:
            self._stray()
        if not columns:
            return None
        if self._time is None:
            self.meter.add(self._next, arrival)
        return Block(np.concatenate(columns, axis=1).astype(np.float32), first, arrival)

    def _ready(self, last: bool) -> bool:
        """Learn the nominal rate from the first rows' own time, if it was not given."""
        if self.rate is None and self._waiting and (len(self._waiting) >= LEARNT_ROWS or last):
            ticks = [row[self._time or 0] for row in self._waiting]
            steps = [b - a for a, b in pairwise(ticks) if b > a]
            if steps:
                self.rate = 1 / (float(np.median(steps)) * self._tick_s)
        return self.rate is not None or last

    def _timed(self, row: list[float]) -> list[NDArray[np.float64]]:
        """Return what a row adds: nothing while its time leaps and no other row says so, too."""
        if self._held is not None:
            if self._follows(row, self._seconds(self._held)):
                held, self._held = self._held, None
                return [*self._placed(held), *self._placed(row)]
            self._stray()
        if self._last_tick is not None and self.rate is not None and not self._follows(row, self._last_tick):
            self._held = row
            return []
        return self._placed(row)

    def _seconds(self, row: list[float]) -> float:
        return self._ticks.seen(row[self._time or 0]) * self._tick_s

    def _follows(self, row: list[float], before_s: float) -> bool:
        return 0 <= (self._seconds(row) - before_s) * (self.rate or 0.0) <= MOST_UNCONFIRMED

    def _stray(self) -> None:
        self._held = None
        self.parser.rejected["stray time"] += 1

    def _placed(self, row: list[float]) -> list[NDArray[np.float64]]:
        """Return a row as samples, behind as many NaN as the board's own time has left out."""
        seconds = self._ticks.add(row[self._time or 0]) * self._tick_s
        found: list[NDArray[np.float64]] = []
        if self._last_tick is not None and self.rate is not None:
            step = seconds - self._last_tick
            if step < 0:
                # Switched on again: its clock began anew, and how long that took is not known.
                self.backward += 1
                self.meter.restart()
                found.append(np.full((len(self.axes), 1), np.nan))
            elif (missing := round(min(step * self.rate, MOST_MISSING)) - 1) > 0:
                found.append(np.full((len(self.axes), missing), np.nan))
        found.append(self._values(row))
        for piece in found:
            self._place(piece)
        self._last_tick = seconds
        self.meter.add(self._next, seconds)
        return found

    def _values(self, row: list[float]) -> NDArray[np.float64]:
        kept = [value for place, value in enumerate(row) if place != self._time]
        column = np.array(kept)[:, None] * self._factor
        # A sample is there in all axes, or lost; what float32 cannot hold is no measurement.
        return column if (np.abs(column) <= _LARGEST).all() else np.full_like(column, np.nan)

    def _place(self, samples: NDArray[np.float64]) -> None:
        lost = int(np.isnan(samples).any(axis=0).sum())
        self._next += samples.shape[1]
        self.lost += lost
        self.received += samples.shape[1] - lost

    def _name_columns(self) -> None:
        """Decide, at the first row, which column is the time, and what the others are called and measured in."""
        headings = [split_heading(name) for name in self.parser.headings]
        names = [name for name, _ in headings]
        self._time = self._time_column(names)
        self._known = True
        if self._time is not None:
            named = headings[self._time][1] if headings else None
            unit = (
                self.form.time_unit
                or named
                or TIME_NAMES.get(names[self._time].lower() if names else "", "us")
            )
            seconds = parse_seconds(unit)
            if seconds is None:
                raise ParameterError(f"time_unit must be s, ms or us, got {unit!r}")
            self._tick_s = seconds
        width = self.parser.columns - (self._time is not None)
        found = [heading for place, heading in enumerate(headings) if place != self._time]
        if self.axes and len(self.axes) != width:
            raise ParameterError(f"{self.name}: axes must be {width} names, got {','.join(self.axes)}")
        if not width:
            raise ParameterError(f"{self.name}: the lines hold a time and nothing else")
        if not self.axes:
            default = {1: ("z",), 3: ("x", "y", "z")}.get(width, tuple(f"c{i + 1}" for i in range(width)))
            distinct = len({name for name, _ in found}) == width
            self.axes = tuple(name for name, _ in found) if found and distinct else default
        units = {unit for _, unit in found if unit}
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
            found = [place for place, name in enumerate(names) if name.lower() in TIME_NAMES]
            return found[0] if len(found) == 1 else None
        if wanted in names:
            return names.index(wanted)
        if wanted.isdigit() and 1 <= int(wanted) <= self.parser.columns:
            return int(wanted) - 1
        known = ", ".join(names) or f"1 to {self.parser.columns}"
        raise ParameterError(f"{self.name}: time must be one of the columns {known}, or none, got {wanted!r}")


class _CounterUnwrapper:
    """A counter of 32 bits that goes on: micros() begins again after 71 minutes."""

    def __init__(self) -> None:
        self._turns, self._last = 0.0, -math.inf

    def seen(self, ticks: float) -> float:
        turns = self._turns
        if self._last - ticks > 2**31 and self._last < 2**32:
            turns += 2**32
        return turns + ticks

    def add(self, ticks: float) -> float:
        seen = self.seen(ticks)
        self._turns, self._last = seen - ticks, ticks
        return seen


def _unit(text: str | None) -> tuple[str, float]:
    return ("1", 1.0) if text is None else parse_unit(text)
