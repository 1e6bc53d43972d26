"""Workbooks: XLSX, XLS and ODS read by calamine, which is quick and knows them all; XLSX written by openpyxl."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError, ParameterError, Remedy
from tactogram.extras import imported
from tactogram.signal.io.archives import UndatedZip, check_archive, decoding
from tactogram.signal.io.content import RawTable, SignalDescription, decode
from tactogram.signal.io.table import heading, table_of_cells
from tactogram.signal.signal import Signal

SHEET = "signal"
DESCRIPTION = "tactogram"
MOST_ROWS = 1_048_576
"""Rows of a worksheet (Excel's limit)."""
MOST_CELLS = 2**25
"""Cells up to the last, 1 GiB in calamine."""
_PLACE = re.compile(rb"""\sr=["']([A-Z]{0,7})(\d{1,12})["']""")


def tables(path: Path, *, sheet: str | None = None) -> list[RawTable]:
    """Return the table in ``sheet``, or in the only one with data."""
    book = _opened(path)
    description = _describe(book, path)
    names = [name for name in book.sheet_names if name != DESCRIPTION]
    if sheet is None and description is not None:
        sheet = SHEET
    if sheet is None:
        data = [name for name in names if not name.startswith("Metadata")]  # of phyphox
        if len(data) != 1:
            raise DataError(
                path,
                "which sheet?",
                remedy=Remedy(f"choose of {', '.join(names)}, e.g.", "sheet", (data or names)[0]),
            )
        [sheet] = data
    if sheet not in names:
        raise DataError(path, f"no sheet {sheet!r}, there are {', '.join(names)}")
    cells = _cells(book, sheet, path)
    if description is None:
        return [table_of_cells(path, cells, name=sheet)]
    columns = np.array(cells[1:], dtype=np.float64).T
    return [
        RawTable(
            path,
            tuple(map(str, cells[0])),
            tuple(columns),
            rows=range(2, len(cells) + 1),
            rate=description.rate,
            description=description,
        )
    ]


def sheets(path: Path) -> dict[str, Sequence[Sequence[object]]]:
    """Return the rows of every sheet by name; None is an empty cell."""
    book = _opened(path)
    return {name: _cells(book, name, path) for name in book.sheet_names}


def describe(path: Path) -> SignalDescription | None:
    """Return the description in the workbook, if there is one."""
    return _describe(_opened(path), path)


def write(path: Path, signal: Signal, description: SignalDescription) -> None:
    """Write the sheet ``signal``, and the description in the first cell of the sheet ``tactogram``."""
    if len(signal) >= MOST_ROWS:
        raise ParameterError(
            f"a worksheet holds at most {MOST_ROWS - 1} samples, got {len(signal)}; write .csv"
        )
    openpyxl = imported("openpyxl", extra="formats", what="workbooks")
    book = openpyxl.Workbook(write_only=True)
    sheet = book.create_sheet(SHEET)
    sheet.append(heading(signal))
    for i, row in enumerate(signal.samples.T.tolist()):
        sheet.append([i / signal.rate, *row])
    book.create_sheet(DESCRIPTION).append([description.encode()])
    for each in book.worksheets:  # or openpyxl complains at its end when the disk is full
        each.close()
    book.properties.created = book.properties.modified = datetime(1980, 1, 1)
    with UndatedZip(path) as archive:  # `book.save` states the time
        openpyxl.writer.excel.ExcelWriter(book, archive).save()


def _opened(path: Path) -> Any:
    calamine = imported("python_calamine", extra="formats", what="workbooks")
    with decoding(path, "truncated or not a workbook", remedy="save it as .xlsx or CSV"):
        if path.suffix.lower() != ".xls":
            with path.open("rb") as file:
                check_archive(file, path)
            _check_cells(path)
        book = calamine.load_workbook(str(path))
    return book


def _check_cells(path: Path) -> None:
    """Raise a `DataError` if a sheet of an XLSX is too large up to its last cell, for all of which calamine makes room.

    It ends the process if it cannot: a workbook of 5 kB whose last cell is filled takes 512 GiB.
    """
    with zipfile.ZipFile(path) as archive:
        for member in archive.namelist():
            addresses = {
                (b"A", 1),
                *((c or b"A", int(r)) for c, r in set(_PLACE.findall(archive.read(member)))),
            }
            column = max((name for name, _ in addresses), key=lambda name: (len(name), name))
            width = sum((byte - 64) * 26**i for i, byte in enumerate(reversed(column)))
            if (cells := width * max(row for _, row in addresses)) > MOST_CELLS:
                raise DataError(
                    path,
                    f"a sheet must have at most {MOST_CELLS} cells up to its last, got {cells}; "
                    "save it as CSV",
                )


def _cells(book: Any, sheet: str, path: Path) -> Sequence[Sequence[object]]:
    with decoding(path, "damaged"):
        rows: list[list[object]] = book.get_sheet_by_name(sheet).to_python(skip_empty_area=False)
    return [[None if cell == "" else cell for cell in row] for row in rows]


def _describe(book: Any, path: Path) -> SignalDescription | None:
    if DESCRIPTION not in book.sheet_names:
        return None
    cells = _cells(book, DESCRIPTION, path)
    return decode(str(cells[0][0]) if cells and cells[0] else "", str(path))
