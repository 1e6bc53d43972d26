"""Source for boards that print a line of numbers per sample: Arduino, Teensy and others."""

from __future__ import annotations

import math
import shlex
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, Message, Remedy
from tactogram.signal import TIME_UNITS, parse_unit
from tactogram_capture.source import Block
from tactogram_capture.stream.byte_source import BAUD, ByteSource, ByteStream
from tactogram_capture.stream.channels import source_facts
from tactogram_capture.stream.csv_lines import (
    RESTART,
    BoardColumns,
    CsvFormat,
    CsvParser,
    columns_of,
    since_reset,
)
from tactogram_capture.stream.rate_estimate import RateEstimate, RateMeter

FIRST_ROWS = 32
"""Rows from which the columns are understood."""
MOST_MISSING = 2_000_000
"""Most samples inserted for one jump of the time column."""
MOST_UNCONFIRMED = 100
"""Rows that the time may skip without a second row to confirm it; a longer jump may be a damaged digit."""
MOST_STRAY = 0.05
"""Share of stray times above which a column without a heading is no time."""
COMPARED_S, MOST_APART = 2.0, 30.0
"""Arrivals after which the board's time is compared with them, s; ratio beyond which its unit is another."""

_LARGEST = float(np.finfo(np.float32).max)


class CsvSource(ByteSource):
    """A board that prints a line per sample; see `tactogram_capture.source.Source`.

    The board's time column reveals lost samples, and NaN takes their place. Without one, only damaged lines are
    noticed: each counts as one lost sample. ``name`` is the address, ``log`` a new file for all bytes. Reading raises
    `DataError` if the columns have two plausible readings; it ends with an address that states one.
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
        self.unit = "1" if form.unit is None else parse_unit(form.unit)[0]
        self.axes: tuple[str, ...] = ()
        self.notes: tuple[str, ...] = ()
        """One line each: which column is the time, what is left out, a missing unit."""
        self.meter = RateMeter()
        self.received = self.lost = self.clock_restarts = 0
        self._columns: BoardColumns | None = None
        self._time: int | None = None
        self._tick_s = 1.0
        self._overflown, self._last_ticks = 0.0, -math.inf
        self._last_s: float | None = None
        self._compared: tuple[float, float] | None = None
        """A time of the board and its arrival, s."""
        self._suspect: list[float] | None = None
        """A row whose time jumps, until the next row confirms it."""
        self._waiting: list[list[float] | None] = []
        """Rows until the columns are understood."""
        self._bytes = self._next = 0

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
            notes=[*self.notes],
        )

    def estimate(self) -> RateEstimate | None:
        """Return the measured rate, from the board's time if it prints one, else from arrival times."""
        return self.meter.estimate()

    def silence(self) -> str:
        """Return what to do if no samples arrive."""
        if self._columns is not None:
            return "is the board still plugged in, and printing?"
        if not self._bytes:
            return "nothing arrives: is it the board's port (`tactogram sources`), and does its sketch print?"
        rows = sum(row is not None for row in self._waiting)
        if rows > self.parser.before + sum(self.parser.rejected.values()):
            return f"{rows} lines of numbers do not suffice to tell the columns: print more often"
        baud = getattr(self.form, "baud", BAUD)
        stated = Remedy("If not, state that, e.g.", "baud", 9600 if baud == BAUD else BAUD)
        question = (
            f"what arrives is not lines of numbers: is {baud} the baud rate of the sketch's Serial.begin?"
        )
        return self._advised(Message(question, stated))

    def _parse(self, data: bytes, arrival_s: float) -> Block | None:
        self._bytes += len(data)
        return self._block(self.parser.feed(data), arrival_s)

    def _finish(self) -> Block | None:
        self.parser.finish()
        return self._block([], float("nan"), last=True)

    def _block(self, rows: list[list[float] | None], arrival: float, *, last: bool = False) -> Block | None:
        for row in rows:
            if row != RESTART:
                self._waiting.append(row)
            elif self._columns is None:
                self.parser.before += sum(row is not None for row in self._waiting)
                self._waiting.clear()
            if self._columns is None and len(self._waiting) >= FIRST_ROWS:
                self._understand()
        if self._columns is None and last:
            self._understand(least=1)
        if self._columns is None:
            return None
        columns: list[NDArray[np.float64]] = []
        first, waiting, self._waiting = self._next, self._waiting, []
        for row in waiting:
            if row is None:
                columns += [self._gap(1)] if self._time is None else []
            elif self._time is None:
                columns.append(self._sample(row))
            elif math.isfinite(row[self._time]):
                columns += self._timed(row)
            else:
                self.parser.rejected["time"] += 1
        if last and self._suspect is not None:
            self._reject_suspect()
        if not columns:
            return None
        if self._time is None:
            self.meter.add(self._next, arrival)
        else:
            self._compare(arrival)
        return Block(np.concatenate(columns, axis=1).astype(np.float32), first, arrival)

    def _understand(self, *, least: int = FIRST_ROWS) -> None:
        """Find out what the columns are if there are ``least`` rows."""
        rows = since_reset(np.array([row for row in self._waiting if row is not None]))
        if len(rows) < least:
            return
        try:
            columns = columns_of(self.parser.head(), rows, self.form, place=Path(self._stream.name))
        except DataError as error:
            raise self._refusal(error.message) from None
        self._columns, self._time, self._tick_s = columns, columns.time, columns.tick_s
        self.axes, self.unit = columns.axes, columns.unit
        self.notes = tuple(map(self._advised, columns.notes))
        if self.rate is None and columns.period_s is not None:
            self.rate = 1 / columns.period_s

    def _refusal(self, message: Message) -> DataError:
        return DataError(self._advised(Message(message, place=self._stream.name)))

    def _advised(self, message: str) -> str:
        """Return a message in which arguments with values are this source's address with them."""

        def address(remedy: Remedy) -> str:
            port, _, query = self.name.partition("?")
            option = f"{remedy.parameter}="
            kept = [part for part in query.split("&") if part and not part.startswith(("log=", option))]
            said = f"`{shlex.quote(f'{port}?' + '&'.join([*kept, f'{option}{remedy.value}']))}`"
            return str(remedy) if remedy.value is None else f"{remedy.advice} {said}"

        # Other names are those of files, whose options the command line has.
        if isinstance(message, Message) and self.name.startswith(("serial:", "log:")):
            return message.in_words(address)
        return message

    def _compare(self, arrival: float) -> None:
        """Raise a `DataError` if the board's time is so far from the arrivals that its unit must be another."""
        if self._columns is None or self._last_s is None or self._compared is None:
            self._compared = None if self._last_s is None else (self._last_s, arrival)
            return
        seconds, arrived = self._last_s - self._compared[0], arrival - self._compared[1]
        if not (arrived > COMPARED_S and seconds > 0):
            return
        self._compared = self._last_s, math.nan
        ratio = seconds / arrived
        if max(ratio, 1 / ratio) > MOST_APART:
            apart = {u: abs(math.log(s * ratio / self._tick_s)) for u, s in TIME_UNITS.items()}
            likely = f"{self._columns.time_name} [{min(apart, key=apart.__getitem__)}]"
            raise self._refusal(
                Message(
                    f"the time in column {self._columns.time_name} runs {ratio:.3g} times as fast as this computer's",
                    Remedy("state its unit,", "time", likely),
                    Remedy("that it is none,", "time", "none"),
                )
            )

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
        """Return the time of a row; a 32-bit counter continues: micros() starts again after 71 minutes."""
        ticks = row[self._time or 0]
        overflows = self._last_ticks - ticks > 2**31 and self._last_ticks < 2**32
        return (self._overflown + 2**32 * overflows + ticks) * self._tick_s

    def _follows(self, row: list[float], before_s: float) -> bool:
        return 0 <= (self._seconds(row) - before_s) * (self.rate or 0.0) <= MOST_UNCONFIRMED

    def _reject_suspect(self) -> None:
        self._suspect = None
        self.parser.rejected["stray time"] += 1
        self._check_time()

    def _check_time(self) -> None:
        """Raise a `DataError` if what was taken for the time goes back too often."""
        stray = self.parser.rejected["stray time"] + self.clock_restarts
        if self._columns is not None and self._columns.guessed and stray > 3 + MOST_STRAY * self.received:
            raise self._refusal(
                Message(
                    f"column {self._columns.time_name}, taken for the time since it rose, also falls",
                    Remedy("if it is an axis, state", "time", "none"),
                    Remedy("else", "time", self._columns.time_name),
                )
            )

    def _placed(self, row: list[float]) -> list[NDArray[np.float64]]:
        """Return a row as a sample, after as many NaN as the board's time skipped."""
        seconds, self._last_ticks = self._seconds(row), row[self._time or 0]
        self._overflown = seconds / self._tick_s - self._last_ticks
        placed: list[NDArray[np.float64]] = []
        if self._last_s is not None and self.rate is not None:
            step = seconds - self._last_s
            if step < 0:
                # The board restarted; its clock began anew, and the duration of the gap is unknown.
                self.clock_restarts += 1
                self.meter.restart()
                self._check_time()
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
        column = np.zeros((0, 1)) if self._columns is None else self._columns.samples(row)
        # A sample is valid in all axes or lost; values beyond float32 are not measurements.
        valid = (np.abs(column) <= _LARGEST).all()
        return self._counted(column if valid else np.full_like(column, np.nan))

    def _counted(self, samples: NDArray[np.float64]) -> NDArray[np.float64]:
        lost = int(np.isnan(samples).any(axis=0).sum())
        self._next += samples.shape[1]
        self.lost += lost
        self.received += samples.shape[1] - lost
        return samples
