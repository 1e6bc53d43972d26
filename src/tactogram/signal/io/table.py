"""CSV and TSV: foreign ones as they are, own ones exact to the last bit."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal.io.columns import (
    DECIMAL_COMMA,
    TableColumns,
    choose,
    is_number,
    table_content,
)
from tactogram.signal.io.content import FileContent
from tactogram.signal.io.description import SignalDescription, decode
from tactogram.signal.io.labels import label_of_cell
from tactogram.signal.io.layout import ColumnUse, TableLayout
from tactogram.signal.io.stamps import StampClock, is_stamp
from tactogram.signal.signal import Signal
from tactogram.text_files import decode_text

COMMENTS = ("#", "%")
SNIFFED_ROWS = 50
_SNIFFED_BYTES = 8192
_BLANK_SEPARATED = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
"""A cell among blanks; in a heading, the unit in brackets belongs to it."""


def read(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> FileContent:
    """Return the content of a text table with one row per sample, if ``labelled`` with the labels of the rows.

    Separated by tab, semicolon, comma or blanks, whichever fits; lines that begin with ``#`` or ``%`` are comments; the
    first other line is a heading if it is not all numbers. Lines of a logger above the heading are omitted. Decimals
    have points, or commas where these do not separate. A `DataError` names the line, counted from 1, and the column.
    """
    table = _read_table(path)
    return table_file_content(
        table, columns=columns, axes=axes, time=time, layouts=layouts, labelled=labelled
    )


def table_file_content(
    table: TextTable,
    *,
    columns: Sequence[str] | None = None,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> FileContent:
    """Return the content of a text table that was taken apart."""
    headings, description = table.headings, table.description
    chosen = table.chosen(columns=columns, axes=axes, time=time, layouts=layouts, labelled=labelled)
    named = not (headings[0] == "1" and headings[-1] == str(len(headings)))
    numbers = table.numbers(chosen)
    labels = table.labels(chosen)
    return table_content(
        numbers, chosen, table.lines, headings, description, table.path, named=named, labels=labels
    )


def headings(path: Path) -> list[str]:
    """Return the headings of a text table; ``"1"``, ``"2"``, … if it has none."""
    return _read_table(path).headings


def is_table(path: Path) -> bool:
    """Return whether most lines at the beginning of a text file are mostly numbers; notes are not."""
    with path.open("rb") as file:
        lines = file.read(_SNIFFED_BYTES).decode("utf-8-sig", "ignore").splitlines()
    rows = [cells for line in lines[:SNIFFED_ROWS] if (cells := re.findall(r"[^\s;,]+", line))]
    numeric = [2 * sum(is_number(cell) or is_stamp(cell) for cell in row) > len(row) for row in rows]
    return 2 * sum(numeric) > len(numeric)


def uses(path: Path, layouts: Sequence[TableLayout]) -> tuple[ColumnUse, ...]:
    """Return what the columns would be read as; a `DataError` where headings and layouts leave that open."""
    return _read_table(path).chosen(layouts=layouts, labelled=True).uses


def describe(path: Path) -> SignalDescription | None:
    """Return the description in the first lines, if there is one."""
    for line in _text(path, 1 << 20).split("\n")[:3]:
        if line.startswith(COMMENTS) and (found := decode(line[1:].strip(), str(path))):
            return found
    return None


def write(path: Path, signal: Signal, description: SignalDescription, *, suffix: str) -> None:
    """Write one row per sample: time (or position), then the axes; nine digits represent float32 exactly."""
    separator = "\t" if suffix == ".tsv" else ","
    rows = np.column_stack([np.arange(len(signal)) / signal.rate, signal.samples.T.astype(np.float64)])
    with path.open("w", encoding="utf-8", newline="") as file:
        file.write(f"# {description.encode()}\n")
        csv.writer(file, delimiter=separator, lineterminator="\n").writerow(heading(signal))
        np.savetxt(file, rows, fmt=["%.12g"] + ["%.9g"] * len(signal.axes), delimiter=separator)


def heading(signal: Signal) -> list[str]:
    """Return the heading of a table of ``signal``, with units."""
    first = "time [s]" if signal.domain == "time" else "position [mm]"
    return [first, *(f"{name} [{signal.unit}]" for name in signal.axes)]


@dataclass(frozen=True)
class TextTable:
    """Lines of a text table, not yet converted to numbers."""

    path: Path
    headings: list[str]
    rows: list[str]  # below the heading
    lines: list[int]  # their numbers in the file, from 1
    comments: list[str]
    separator: str

    @cached_property
    def description(self) -> SignalDescription | None:
        """The description in the first comments, if there is one."""
        descriptions = (decode(line, str(self.path)) for line in self.comments[:3])
        return next((found for found in descriptions if found), None)

    def chosen(
        self,
        *,
        columns: Sequence[str] | None = None,
        axes: Sequence[str] | None = None,
        time: str | None = None,
        layouts: Sequence[TableLayout] = (),
        labelled: bool = False,
    ) -> TableColumns:
        """Return the columns to read."""
        return choose(
            self.headings,
            self.path,
            self.description,
            columns=columns,
            axes=axes,
            time=time if self.description is None else self.headings[0],
            layouts=layouts,
            rows=[_cells(row, self.separator, self.path) for row in self.rows[:SNIFFED_ROWS]],
            labelled=labelled,
        )

    def labels(self, chosen: TableColumns) -> dict[str, list[str]]:
        """Return the labels of the rows by role."""
        if not chosen.labels:
            return {}
        rows = [_cells(row, self.separator, self.path) for row in self.rows]
        return {role: [label_of_cell(row[i]) for row in rows] for role, i in chosen.labels.items()}

    def numbers(self, chosen: TableColumns) -> NDArray[np.float64]:
        """Return the used columns as float64, shape (row, used column); between stamps an empty cell is NaN."""
        quoted = any('"' in row for row in self.rows)
        count = len(self.headings)
        if self.separator == " " or quoted:
            complete = all(len(_cells(row, self.separator, self.path)) == count for row in self.rows)
        else:
            complete = all(row.count(self.separator) == count - 1 for row in self.rows)
        for converter in (None, _number_or_nan) if chosen.stamped else (None,):
            converters: dict[int | str, Callable[[str], float]] = {}
            if converter is not None:
                converters |= dict.fromkeys(chosen.used, converter)
            if chosen.dated and chosen.time is not None:
                converters[chosen.time] = StampClock()
            with suppress(ValueError):
                if complete:
                    return np.loadtxt(
                        self.rows,
                        delimiter=None if self.separator == " " else self.separator,
                        usecols=chosen.used,
                        comments=None,
                        quotechar='"' if quoted else None,
                        ndmin=2,
                        converters=converters or None,
                    )
        raise DataError(f"{self.path}: {self._problem(chosen)}")

    def _problem(self, chosen: TableColumns) -> str:
        """Return what is wrong with the first invalid row."""
        clock = StampClock()
        for number, row in zip(self.lines, self.rows, strict=True):
            cells = _cells(row, self.separator, self.path)
            if len(cells) != len(self.headings):
                comma = self.separator == "," and len(cells) == 2 * len(self.headings)
                hint = "; write decimal points, not commas" if comma else ""
                return f"row {number}: expected {len(self.headings)} columns, got {len(cells)}{hint}"
            for i in chosen.used:
                if i == chosen.time and chosen.dated:
                    try:
                        clock(cells[i])
                    except ValueError as error:
                        return f"row {number}, column {self.headings[i]!r}: {error}"
                    continue
                if is_number(cells[i]):
                    continue
                comma = DECIMAL_COMMA.fullmatch(cells[i]) is not None
                hint = "write decimal points, not commas" if comma else "choose the columns to read"
                got = repr(cells[i]) if cells[i] else "nothing"
                return f"row {number}, column {self.headings[i]!r}: expected a number, got {got}; {hint}"
        return "not a table of numbers"


def _read_table(path: Path) -> TextTable:
    lines = read_lines(path)
    comments = [line[1:].strip() for line in lines if line.startswith(COMMENTS)]
    kept = [
        n for n, line in enumerate(lines, 1) if line and not line.isspace() and not line.startswith(COMMENTS)
    ]
    rows = [lines[n - 1] for n in kept]
    if not rows:
        raise DataError(f"{path}: no rows")
    separator = "\t" if path.suffix.lower() == ".tsv" else _separator(rows)
    preamble = _preamble(rows, separator, path)
    kept, rows = kept[preamble:], rows[preamble:]
    headings = _cells(rows[0], separator, path)
    if all(is_number(cell) or is_stamp(cell) for cell in headings):
        headings = _commented(comments, len(headings), separator, path) or [
            str(i + 1) for i in range(len(headings))
        ]
    else:
        kept, rows = kept[1:], rows[1:]
    if not rows:
        raise DataError(f"{path}: no rows below the heading")
    rows, headings = _without_last_separator(rows, headings, separator)
    if separator != "," and _has_decimal_commas(rows, separator, path):
        rows = [row.replace(",", ".") for row in rows]
    return TextTable(path, headings, rows, kept, comments, separator)


def read_lines(path: Path) -> list[str]:
    """Return the lines of a text file; a `DataError` if it is empty or not UTF-8."""
    return _text(path).split("\n")


def _text(path: Path, length: int = -1) -> str:
    with path.open("rb") as file:
        raw = file.read(length)
    if not raw:
        raise DataError(f"{path}: empty file")
    text = decode_text(raw, path, cut_short=length >= 0)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _separator(rows: Sequence[str]) -> str:
    """Return the separator of the first rows: the first candidate that is in every one of them."""
    first = rows[:SNIFFED_ROWS]
    for candidate in ("\t", ";", ","):
        if all(candidate in row for row in first):
            return candidate
    # If most rows have it, the others are wrong, not the separator.
    for candidate in ("\t", ";", ","):
        if sum(candidate in row for row in first) > len(first) / 2:
            return candidate
    return " "


def _preamble(rows: Sequence[str], separator: str, path: Path) -> int:
    """Return the number of lines that a logger wrote above the heading: these have other numbers of cells."""
    if separator == " ":
        return 0
    counts = [len(_cells(row, separator, path)) for row in rows[:SNIFFED_ROWS]]
    common = max(set(counts), key=counts.count)
    first = counts.index(common)
    headed = not any(is_number(cell) for cell in _cells(rows[first], separator, path))
    return first if headed else 0


def _has_decimal_commas(rows: Sequence[str], separator: str, path: Path) -> bool:
    """Return whether numbers have commas, and none has a point."""
    cells = [cell for row in rows[:SNIFFED_ROWS] for cell in _cells(row, separator, path)]
    return any(DECIMAL_COMMA.fullmatch(cell) for cell in cells) and not any(
        "." in cell and is_number(cell) for cell in cells
    )


def _cells(row: str, separator: str, path: Path) -> list[str]:
    if separator == " ":
        return _BLANK_SEPARATED.findall(row)
    try:
        [cells] = csv.reader([row], delimiter=separator, skipinitialspace=True)
    except csv.Error as error:
        raise DataError(f"{path}: not a table: {error}; is a quote left open?") from None
    return [cell.strip() for cell in cells]


def _commented(comments: Sequence[str], count: int, separator: str, path: Path) -> list[str] | None:
    """Return the last comment as headings if it has as many cells as the table, as numpy.savetxt writes it."""
    if not comments or decode(comments[-1], "") is not None:
        return None
    if len(comments[-1]) > csv.field_size_limit():
        return None
    cells = _cells(comments[-1], separator, path)
    return cells if len(cells) == count and not any(is_number(cell) for cell in cells) else None


def _without_last_separator(
    rows: list[str], headings: list[str], separator: str
) -> tuple[list[str], list[str]]:
    """Return the table without the empty last column of rows that all end with the separator."""
    if separator == " " or not all(row.rstrip(" ").endswith(separator) for row in rows):
        return rows, headings
    if not headings[-1] or headings[-1].isdigit():
        headings = headings[:-1]
    elif rows[0].count(separator) == len(headings) - 1:  # an empty column with a heading
        return rows, headings
    return [row.rstrip(" ")[:-1] for row in rows], headings


def _number_or_nan(cell: str) -> float:
    if not cell.strip():
        return math.nan
    if not is_number(cell):
        raise ValueError
    return float(cell)
