"""Lines of numbers, as boards print them: parsed from bytes that may be cut or damaged anywhere, and their columns."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import Message, Remedy
from tactogram.signal import parse_unit
from tactogram.signal.io import (
    RawTable,
    TableHead,
    default_axes,
    head_of,
    pairs_in,
    roles_of,
    unit_note,
    unstamped,
)
from tactogram.validation import FrozenModel
from tactogram_capture.stream.channels import axis_names

LONGEST_LINE = 4096
COMMENTS = ("#", "%", "//")
RESTART: list[float] = []
"""Row in place of a heading among the rows: the board was reset."""

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_NOT_FINITE = re.compile(r"[+-]?(?:nan|inf|infinity|ovf)", re.IGNORECASE)


class CsvParser:
    """Parser of bytes in arbitrary pieces into rows of numbers."""

    def __init__(self) -> None:
        self.rejected: Counter[str] = Counter()
        """Lines after the first row that are not rows, by reason."""
        self.before = self.comments = 0
        """Lines before the first row: start-up messages, and the partial line at which reading begins."""
        self.columns = 0
        self._buffer = bytearray()
        self._too_long = False
        self._separator: str | None = None
        self._names: list[str] = []  # of pairs
        self._above: list[tuple[list[str], str | None]] = []  # lines of words, and their separators
        self._candidate: int | None = None  # cells of the row before the first one

    def feed(self, data: bytes) -> list[list[float] | None]:
        """Return the rows that ``data`` completes; None for a line that is not a row, `RESTART` for a heading."""
        self._buffer += data
        rows: list[list[float] | None] = []
        while True:
            end = self._buffer.find(b"\n", 0, LONGEST_LINE)
            if end >= 0:
                line = bytes(self._buffer[:end])
                del self._buffer[: end + 1]
                if self._too_long:
                    self._too_long = False
                else:
                    self._line(line, rows)
            elif len(self._buffer) > LONGEST_LINE:
                if not self._too_long:
                    self._no_row("line without an end", rows)
                self._too_long = True
                del self._buffer[:LONGEST_LINE]
            else:
                return rows

    def finish(self) -> None:
        """Reject an unfinished last line, which may lack digits."""
        if self._buffer.strip():
            self.rejected["unfinished"] += 1
        self._buffer.clear()

    def head(self) -> TableHead:
        """Return the headings of the columns, and their units."""
        fitting = [cells for cells, separator in self._above if self._fits(cells, separator)]
        return head_of(fitting, self.columns)

    def rejected_text(self) -> str:
        """Return the count of unreadable lines, for an error."""
        return f"{self.before + sum(self.rejected.values())} unreadable lines, {self.comments} comments"

    def _line(self, line: bytes, rows: list[list[float] | None]) -> None:
        text = unstamped(line.decode("utf-8", "replace").strip("\r \t\0"))
        if text[:1] in ("(", "[") and text[-1] in (")", "]"):  # as Python prints tuples and lists
            text = text[1:-1]
        comment = text.startswith(COMMENTS)
        self.comments += comment
        names, cells, separator = _cells(text.lstrip("#%/ ") if comment else text)
        values = [_value(cell) for cell in cells]
        if not cells or (comment and (self.columns or None not in values)):
            return
        if None in values:
            self._words(cells, separator, rows, comment=comment)
            return
        row = [value for value in values if value is not None]
        if not self.columns:
            if self._is_first(row, separator):
                self.columns, self._separator, self._names = len(row), separator, names
                self._above = [(names, separator)] if names else self._above
                rows.append(row)
        elif not self._fits(cells, separator) or names != self._names:
            self._no_row("number of columns", rows)
        else:
            rows.append(row)

    def _words(
        self, cells: list[str], separator: str | None, rows: list[list[float] | None], *, comment: bool
    ) -> None:
        """Keep a line that may be a heading; among the rows it begins them anew, and other words are no row."""
        cells = [re.sub(r"^[\x00-\x1f\ufffd]+", "", cells[0]), *cells[1:]]  # noise of a reset
        heading = all(cell[:1].isalpha() for cell in cells)
        if not self.columns:
            self.before += not comment
            if heading:
                self._above = [*self._above[-3:], (cells, separator)]
                self._candidate = None
        elif (cells, separator) in self._above or (
            heading and self.columns > 1 and self._fits(cells, separator) and not self.head().named
        ):
            self._above = [(cells, separator)]
            rows.append(RESTART)
        else:
            self._no_row("not numbers", rows)

    def _is_first(self, row: list[float], separator: str | None) -> bool:
        """Return whether a row is the first complete one: as wide as a heading or the preceding row."""
        if any((len(row), separator) == (len(cells), by) for cells, by in self._above):
            return True
        # The preceding row has as many cells but may lack its first digits.
        self.before += self._candidate is not None
        first, self._candidate = self._candidate == len(row), len(row)
        return first

    def _fits(self, cells: list[str], separator: str | None) -> bool:
        return len(cells) == self.columns and (self.columns == 1 or separator == self._separator)

    def _no_row(self, why: str, rows: list[list[float] | None]) -> None:
        if self.columns:
            self.rejected[why] += 1
            rows.append(None)
        else:
            self.before += 1


def _cells(text: str) -> tuple[list[str], list[str], str | None]:
    """Return the names (of ``name:value`` pairs, a format of serial plotters), cells and separator of a line."""
    if pairs := pairs_in(text) if ":" in text or "=" in text else []:
        return (
            [f"{name} [{unit}]" if unit else name for name, _, unit in pairs],
            [v for _, v, _ in pairs],
            "\t",
        )
    separator = next((s for s in ("\t", ";", ",") if s in text), None)
    cells = [cell.strip() for cell in (text.split(separator) if separator else text.split())]
    return [], cells[:-1] if separator and not cells[-1] else cells, separator


def _value(cell: str) -> float | None:
    if _NUMBER.fullmatch(cell):
        return float(cell)
    return math.nan if _NOT_FINITE.fullmatch(cell) else None


class CsvFormat(FrozenModel):
    """Format of a board's lines; by default the columns are understood as those of a table in a file."""

    time: str | None = None
    """Column of the board's time, by name or number (from 1), with its unit if need be (``ticks [us]``); ``"none"`` if
    there is none."""
    unit: str | None = None
    """Unit of the samples: m/s^2, g, mg, V, N, …, or of counts: g/16384; by default the heading's, or 1."""
    scale: float = Field(default=1.0, allow_inf_nan=False)
    """Factor from the printed numbers to that unit."""
    rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Nominal rate, Hz; by default learnt from the board's time."""
    axes: str | None = None
    """Columns of the samples by name or number, separated by commas, or new names for them."""


@dataclass(frozen=True, eq=False)
class BoardColumns:
    """Columns of a board's lines: its time, and the axes of one quantity."""

    time: int | None
    time_name: str
    guessed: bool  # since it has no name
    tick_s: float
    period_s: float | None  # typical step of the time
    places: tuple[int, ...]  # of the axes
    axes: tuple[str, ...]
    unit: str
    factors: NDArray[np.float64]  # to the unit, shape (axis, 1)
    notes: tuple[str, ...]

    def samples(self, row: Sequence[float]) -> NDArray[np.float64]:
        """Return the sample in a row, float64, shape (axis, 1), ``unit``."""
        return np.array([[row[column]] for column in self.places]) * self.factors


def columns_of(head: TableHead, rows: NDArray[np.float64], form: CsvFormat, *, place: Path) -> BoardColumns:
    """Return the columns of lines, by their headings and the first rows, float64, shape (row, column).

    A `DataError` says what to state if there are two plausible readings; a `ParameterError`
    or `UnitError` that ``form`` does not fit the lines.
    """
    table = RawTable(place, head.headings, tuple(rows.T), units=head.units, named=head.named, brief=True)
    names = [name.strip() for name in form.axes.split(",")] if form.axes else None
    roles = roles_of(table, axes=names, time=form.time, rate=form.rate)
    stream, *others = roles.streams
    axes = stream.axes if head.named else default_axes(len(stream.axes))
    if form.axes and not stream.chosen:
        axes = axis_names(len(axes), form.axes, where=str(place))
    unit, factors = stream.unit or "1", stream.factors
    if form.unit is not None:
        unit, factor = parse_unit(form.unit)
        factors = (factor,) * len(axes)
    notes, steps = ["no column of time: only damaged lines are counted as lost"], np.zeros(0)
    if roles.time is not None:
        notes = [f"time from {head.headings[roles.time]}"] if head.named else []
        steps = np.diff(rows[:, roles.time]) * (roles.seconds or 1.0)
    listed = ", ".join(head.headings[i] for i in stream.places)
    notes += [*roles.notes, f"{', '.join(axes)} from {'' if head.named else 'column '}{listed}, unit {unit}"]
    if form.unit is None and (note := unit_note(stream, roles.uses, rows.T[[*stream.places]])):
        notes.append(note)
    for other in others:
        listed = ",".join(head.headings[i] for i in other.places)
        left = f"left out: {listed} ({other.name.replace('_', ' ')})"
        notes.append(Message(left, Remedy("to read them instead,", "axes", listed)))
    return BoardColumns(
        roles.time,
        head.headings[roles.time or 0],
        guessed=form.time is None and not head.named,
        tick_s=roles.seconds or 1.0,
        period_s=float(np.median(steps[steps > 0])) if (steps > 0).any() else None,
        places=stream.places,
        axes=axes,
        unit=unit,
        factors=form.scale * np.array(factors)[:, None],
        notes=tuple(notes),
    )


def since_reset(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows after the only step back in the first column: the board was reset, or its counter overflowed."""
    back = np.flatnonzero(np.diff(rows[:, 0]) < 0) if len(rows) else np.zeros(0, int)
    return rows[back[0] + 1 :] if len(back) == 1 and len(rows) - back[0] > 2 else rows
