"""CSV and TSV: foreign ones as they are, own ones exact to the last bit."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal.io.columns import TableColumns, choose, table_content
from tactogram.signal.io.content import FileContent
from tactogram.signal.io.description import SignalDescription, decode
from tactogram.signal.signal import Signal
from tactogram.signal.units import split_heading
from tactogram.text_files import decode_text

COMMENTS = ("#", "%")
_SNIFFED_ROWS = 50
_BLANK_SEPARATED = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?")
"""A cell among blanks; in a heading, the unit in brackets belongs to it."""


def read(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    axes: Sequence[str] | None = None,
    time: str | None = None,
) -> FileContent:
    """Return the content of a text table with one row per sample.

    Separated by tab, semicolon, comma or blanks, whichever fits; lines that begin with ``#`` or ``%`` are comments; the
    first other line is a heading if it is not all numbers. Decimal points only. A `DataError` names the line, counted
    from 1, and the column.
    """
    headings, rows, kept, comments, separator = _rows(path)
    descriptions = [found for line in comments[:3] if (found := decode(line, str(path)))]
    description = descriptions[0] if descriptions else None
    stamps = headings[0] if description is not None else time
    chosen = choose(headings, path, description, columns=columns, axes=axes, time=stamps)
    numbers = _numbers(rows, kept, headings, chosen, separator, path)
    named = not (headings[0] == "1" and headings[-1] == str(len(headings)))
    return table_content(numbers, chosen, kept, headings, description, path, named=named)


def headings(path: Path) -> list[str]:
    """Return the names of the columns of a text table without units; ``"1"``, ``"2"``, … if it has no heading."""
    return [split_heading(name)[0] for name in _rows(path)[0]]


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


def _rows(path: Path) -> tuple[list[str], list[str], list[int], list[str], str]:
    """Return headings, the rows below them and their line numbers, comments, and the separator."""
    text = _text(path)
    lines = text.split("\n")
    comments = [line[1:].strip() for line in lines if line.startswith(COMMENTS)]
    kept = [
        n for n, line in enumerate(lines, 1) if line and not line.isspace() and not line.startswith(COMMENTS)
    ]
    rows = [lines[n - 1] for n in kept]
    if not rows:
        raise DataError(f"{path}: no rows")
    separator = "\t" if path.suffix.lower() == ".tsv" else _separator(rows)
    headings = _cells(rows[0], separator, path)
    if all(_is_number(cell) for cell in headings):
        headings = _commented(comments, len(headings), separator, path) or [
            str(i + 1) for i in range(len(headings))
        ]
    else:
        kept, rows = kept[1:], rows[1:]
    if not rows:
        raise DataError(f"{path}: no rows below the heading")
    rows, headings = _without_last_separator(rows, headings, separator)
    return headings, rows, kept, comments, separator


def _text(path: Path, length: int = -1) -> str:
    with path.open("rb") as file:
        raw = file.read(length)
    if not raw:
        raise DataError(f"{path}: empty file")
    text = decode_text(raw, path, cut_short=length >= 0)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _separator(rows: Sequence[str]) -> str:
    """Return the separator of the first rows: the first candidate that is in every one of them."""
    first = rows[:_SNIFFED_ROWS]
    for candidate in ("\t", ";", ","):
        if all(candidate in row for row in first):
            return candidate
    # If most rows have it, the others are wrong, not the separator.
    for candidate in ("\t", ";", ","):
        if sum(candidate in row for row in first) > len(first) / 2:
            return candidate
    return " "


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
    return cells if len(cells) == count and not any(_is_number(cell) for cell in cells) else None


def _without_last_separator(
    rows: list[str], headings: list[str], separator: str
) -> tuple[list[str], list[str]]:
    """Return the table without the empty last column of rows that all end with the separator."""
    if separator == " " or not all(row.rstrip(" ").endswith(separator) for row in rows):
        return rows, headings
    if not headings[-1] or headings[-1].isdigit():
        headings = headings[:-1]
    return [row.rstrip(" ")[:-1] for row in rows], headings


def _numbers(
    rows: Sequence[str],
    kept: Sequence[int],
    headings: Sequence[str],
    chosen: TableColumns,
    separator: str,
    path: Path,
) -> NDArray[np.float64]:
    """Return the used columns as float64, shape (row, used column)."""
    quoted = any('"' in row for row in rows)
    if separator != " " and not quoted:
        wanted = len(headings) - 1
        if any(row.count(separator) != wanted for row in rows):
            _explain(rows, kept, headings, chosen, separator, path)
    elif any(len(_cells(row, separator, path)) != len(headings) for row in rows):
        _explain(rows, kept, headings, chosen, separator, path)
    try:
        return np.loadtxt(
            rows,
            delimiter=None if separator == " " else separator,
            usecols=chosen.used,
            comments=None,
            quotechar='"' if quoted else None,
            ndmin=2,
        )
    except ValueError:
        _explain(rows, kept, headings, chosen, separator, path)


def _explain(
    rows: Sequence[str],
    kept: Sequence[int],
    headings: Sequence[str],
    chosen: TableColumns,
    separator: str,
    path: Path,
) -> NoReturn:
    """Raise the error of the first invalid row."""
    for number, row in zip(kept, rows, strict=True):
        cells = _cells(row, separator, path)
        if len(cells) != len(headings):
            comma = separator == "," and len(cells) == 2 * len(headings)
            hint = "; write decimal points, not commas" if comma else ""
            raise DataError(f"{path}: row {number}: expected {len(headings)} columns, got {len(cells)}{hint}")
        for i in chosen.used:
            if _is_number(cells[i]):
                continue
            comma = re.fullmatch(r"[-+]?\d*,\d+([eE][-+]?\d+)?", cells[i]) is not None
            hint = "write decimal points, not commas" if comma else "choose the columns to read"
            got = repr(cells[i]) if cells[i] else "nothing"
            raise DataError(
                f"{path}: row {number}, column {headings[i]!r}: expected a number, got {got}; {hint}"
            )
    raise DataError(f"{path}: not a table of numbers")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell
