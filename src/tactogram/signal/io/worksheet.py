"""XLSX: one row per sample, as in a text table, read row by row by openpyxl, which is imported when one is met."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, islice
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import ParseError

import numpy as np

from tactogram.errors import DataError, ParameterError, one_line
from tactogram.signal.io.archives import check_archive
from tactogram.signal.io.columns import choose, table_content
from tactogram.signal.io.content import ZIP_ERRORS, FileContent
from tactogram.signal.io.description import SignalDescription, decode
from tactogram.signal.io.labels import label_of_cell
from tactogram.signal.io.layout import TableLayout
from tactogram.signal.io.stamps import StampClock, is_stamp
from tactogram.signal.io.table import SNIFFED_ROWS, heading
from tactogram.signal.signal import Signal

SHEET = "signal"
DESCRIPTION = "tactogram"
MOST_ROWS = 1_048_576
"""Rows of a worksheet (Excel's limit)."""


def read(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    sheet: str | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> FileContent:
    """Return the content of a worksheet, ``sheet`` or the only one; its first row that is not empty is the heading.

    A `DataError` names the row, as numbered in the sheet, and the column.
    """
    with _opened(path) as book:
        description = _describe(book, path)
        headings, named, below = _headed(_sheet(book, path, sheet, description), path)
        sniffed = [*islice(below, SNIFFED_ROWS)]
        chosen = choose(
            headings,
            path,
            description,
            columns=columns,
            axes=axes,
            time=headings[0] if description is not None else time,
            layouts=layouts,
            rows=[row for _, row in sniffed],
            labelled=labelled,
        )
        clock = StampClock()
        kept: list[int] = []
        values: list[list[float]] = []
        labels: dict[str, list[str]] = {role: [] for role in chosen.labels}
        for number, row in chain(sniffed, below):
            kept.append(number)
            for role, i in chosen.labels.items():
                labels[role].append(label_of_cell(row[i] if i < len(row) else None))
            gaps = chosen.places if chosen.stamped else ()
            dated = chosen.time if chosen.dated else None
            values.append(
                [
                    _seconds(clock, row, i, number, headings, path)
                    if i == dated
                    else _number(row, i, number, headings, path, gap=i in gaps)
                    for i in chosen.used
                ]
            )
    if not values:
        raise DataError(f"{path}: no rows below the heading")
    numbers = np.array(values, dtype=np.float64)
    return table_content(numbers, chosen, kept, headings, description, path, named=named, labels=labels)


def headings(path: Path) -> list[str]:
    """Return the headings of the only worksheet."""
    with _opened(path) as book:
        return _headed(_sheet(book, path, None, _describe(book, path)), path)[0]


def describe(path: Path) -> SignalDescription | None:
    """Return the description in the workbook, if there is one."""
    with _opened(path) as book:
        return _describe(book, path)


def write(path: Path, signal: Signal, description: SignalDescription) -> None:
    """Write the sheet ``signal``, and the description in the first cell of the sheet ``tactogram``."""
    if len(signal) >= MOST_ROWS:
        raise ParameterError(
            f"a worksheet holds at most {MOST_ROWS - 1} samples, got {len(signal)}; write .csv"
        )
    import openpyxl

    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet(SHEET)
    sheet.append(heading(signal))
    for i, row in enumerate(signal.samples.T.tolist()):
        sheet.append([i / signal.rate, *row])
    book.create_sheet(DESCRIPTION).append([description.encode()])
    book.save(path)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """Yield the workbook, unpacked once before to find damage early."""
    if path.stat().st_size == 0:
        raise DataError(f"{path}: empty file")
    try:
        with path.open("rb") as file:
            check_archive(file, path)
        with zipfile.ZipFile(path) as archive:
            damaged = archive.testzip()
    except ZIP_ERRORS as error:
        raise DataError(f"{path}: truncated or not an XLSX file: {one_line(error)}") from error
    if damaged is not None:
        raise DataError(f"{path}: damaged: checksum of {damaged} is wrong")
    import openpyxl
    from openpyxl.utils.exceptions import InvalidFileException

    with path.open("rb") as file:
        try:
            book = openpyxl.load_workbook(file, read_only=True, data_only=True)
        except (InvalidFileException, ParseError, KeyError, ValueError, TypeError, AttributeError) as error:
            raise DataError(f"{path}: not an XLSX file: {one_line(error)}") from error
        try:
            yield book
        except ParseError as error:
            raise DataError(f"{path}: damaged: {one_line(error)}") from error
        finally:
            book.close()


def _describe(book: Any, path: Path) -> SignalDescription | None:
    if DESCRIPTION not in book.sheetnames:
        return None
    first = next(book[DESCRIPTION].iter_rows(max_row=1, values_only=True), (None,))
    return decode(str(first[0]), str(path))


def _sheet(book: Any, path: Path, sheet: str | None, description: SignalDescription | None) -> Any:
    names = [name for name in book.sheetnames if name != DESCRIPTION]
    if sheet is None:
        data = [name for name in names if not name.startswith("Metadata")]  # of phyphox
        if description is None and len(data) != 1:
            raise DataError(f"{path}: which sheet? choose of {', '.join(names)}")
        sheet = SHEET if description is not None else data[0]
    if sheet not in names:
        raise DataError(f"{path}: no sheet {sheet!r}, there are {', '.join(names)}")
    return book[sheet]


def _headed(sheet: Any, path: Path) -> tuple[list[str], bool, Iterator[tuple[int, Sequence[Any]]]]:
    """Return the headings, whether the sheet has them, and the numbered rows below that are not empty."""
    rows = enumerate(sheet.iter_rows(values_only=True), 1)
    filled = ((n, row) for n, row in rows if any(cell not in (None, "") for cell in row))
    first, head = next(filled, (0, ()))
    width = max((i for i, cell in enumerate(head, 1) if cell not in (None, "")), default=0)
    if not width:
        raise DataError(f"{path}: no rows")
    named = not all(isinstance(cell, int | float) or is_stamp(cell) for cell in head[:width])
    texts = [str(cell if cell is not None else "").strip() for cell in head[:width]]
    if named:
        return texts, True, filled
    return [str(i + 1) for i in range(width)], False, chain([(first, head)], filled)


def _seconds(
    clock: StampClock, row: Sequence[Any], i: int, number: int, headings: Sequence[str], path: Path
) -> float:
    try:
        return clock(row[i] if i < len(row) else None)
    except ValueError as error:
        raise DataError(f"{path}: row {number}, column {headings[i]!r}: {error}") from None


def _number(
    row: Sequence[Any], i: int, number: int, headings: Sequence[str], path: Path, *, gap: bool
) -> float:
    cell = row[i] if i < len(row) else None
    if gap and cell in (None, ""):
        return math.nan
    if isinstance(cell, int | float) and not isinstance(cell, bool):
        return float(cell)
    got = "nothing" if cell in (None, "") else repr(cell)
    raise DataError(f"{path}: row {number}, column {headings[i]!r}: expected a number, got {got}")
