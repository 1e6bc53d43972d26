"""Table cells: as text whatever the file, values, or an error that names the cell; the size of a Parquet table."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.extras import imported
from tactogram.signal.io.archives import decoding
from tactogram.signal.io.worksheet import sheets
from tactogram.text_files import check_regular, csv_rows, detected_text, parse_json, read_bytes, read_text

_SNIFFED = 100_000
MIB = 2**20
MOST_ROWS = 2_000_000
MOST_BYTES = 256 * MIB


class Cells(NamedTuple):
    """A table as text: headings, rows with their numbers as in a spreadsheet, and what was left out.

    Each row has a cell for each heading; a heading may be empty.
    """

    headings: list[str]
    rows: list[tuple[int, list[str]]]
    notes: list[str]


def read_cells(path: Path, *, encoding: str = "") -> Cells:
    """Return the cells of a CSV, TSV, Parquet, XLSX or JSON file (records), without rows that are empty.

    The encoding of a text is detected unless it is given. A `DataError` names the file, and the row that has too few or
    too many cells.
    """
    notes: list[str] = []
    match path.suffix.lower():
        case ".parquet":
            table = read_parquet(path)
            lists = [column.to_pylist() for column in table.columns]
            rows = [(0, list(table.column_names)), *enumerate(map(list, zip(*lists, strict=True)), 1)]
        case ".xlsx":
            rows = _sheet(path)
        case ".json":
            rows = _records(path)
        case suffix:
            if encoding:
                text = read_text(path, encoding=encoding)
            else:
                text, detected = detected_text(read_bytes(path), path)
                notes += [] if detected.startswith("utf") else [f"text read as {detected}, not UTF-8"]
            divider = "\t" if suffix == ".tsv" else max(",;\t", key=partial(_columns, text[:_SNIFFED]))
            rows = [(n, [*row]) for n, row in csv_rows(text, path, delimiter=divider)]
    cells = [(number, [cell_text(cell) for cell in row]) for number, row in rows]
    headings = [heading.strip() for heading in cells[0][1]] if cells else []
    if not any(headings):
        raise DataError(path, "must begin with a row of headings, got none")
    named = max(n for n, heading in enumerate(headings, 1) if heading)
    kept = []
    for number, row in cells[1:]:
        if any(map(str.strip, row)):
            if len(row) < named or any(map(str.strip, row[len(headings) :])):
                raise DataError(f"{path}: row {number}", f"must have {len(headings)} cells, got {len(row)}")
            kept.append((number, (row + [""] * len(headings))[: len(headings)]))
    if unnamed := [str(n) for n, heading in enumerate(headings, 1) if not heading]:
        notes.append(f"columns left out, as they have no heading: {', '.join(unnamed)}")
    return Cells(headings, kept, notes)


def cell_text(value: Any) -> str:
    """Return a cell as text: 3.0 and 3 are the same score, rater or item."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict | list):
        return json.dumps(value, ensure_ascii=False)
    return repr(int(value)) if isinstance(value, float) and value.is_integer() else str(value)


def _columns(text: str, divider: str) -> int:
    return len(next(csv.reader(io.StringIO(text, newline=""), delimiter=divider), []))


def _sheet(path: Path) -> list[tuple[int, list[Any]]]:
    check_regular(path)
    rows = {
        name: [(n, [*row]) for n, row in enumerate(cells, 1) if any(cell is not None for cell in row)]
        for name, cells in sheets(path).items()
    }
    if sum(map(bool, rows.values())) > 1:
        raise DataError(path, f"must have one sheet, got {', '.join(rows)}; save that of the answers as CSV")
    return [row for sheet in rows.values() for row in sheet]


def _records(path: Path) -> list[tuple[int, list[Any]]]:
    records = parse_json(detected_text(read_bytes(path), path)[0], path)
    if not isinstance(records, list) or not all(isinstance(row, dict) for row in records):
        raise DataError(path, "must hold a list of objects, one per row")
    names = list(dict.fromkeys(name for row in records for name in row))
    return [(0, names), *((n, [row.get(name) for name in names]) for n, row in enumerate(records, 1))]


def finite_number(where: object, name: str, text: str | None) -> float:
    """Return the text of a table cell as a finite number; errors name ``where`` (file and row) and the column."""
    stripped = (text or "").strip()
    try:
        value = float(stripped)
    except ValueError:
        raise DataError(where, f"{name} must be a number, got {stripped!r}") from None
    if not math.isfinite(value):
        raise DataError(where, f"{name} must be a finite number, got {stripped!r}")
    return value


def number_columns(
    path: Path, names: Sequence[str] | None = None, *, separator: str = ",", least: int = 1
) -> NDArray[np.float64]:
    """Return columns of a CSV, XLSX or Parquet file by their headings, float64, shape (column, row).

    Without ``names`` the file has no heading, and all columns are returned. A cell that is no finite number is a
    `DataError`, as are a missing column and fewer than ``least`` rows.
    """
    import pandas as pd

    head = None if names is None else 0
    if path.suffix.lower() == ".xlsx":
        imported("openpyxl", extra="formats", what="workbooks")
    with decoding(path, "not a readable table"):
        match path.suffix.lower():
            case ".xlsx":
                table = pd.read_excel(path, header=head, engine="openpyxl")
            case ".parquet":
                table = pd.read_parquet(path)
            case _:
                table = pd.read_csv(path, header=head, sep=separator, index_col=False, skip_blank_lines=False)
                table = table.dropna(how="all")
    if lacking := [name for name in names or () if name not in table]:
        raise DataError(
            path,
            f"needs columns {_listed(names or ())}, lacks {_listed(lacking)}, has {_listed(table.columns)}",
        )
    chosen = table if names is None else table[list(names)]
    if len(chosen) < least:
        raise DataError(path, f"must have {least} or more rows of samples, got {len(chosen)}")
    values = np.array([pd.to_numeric(chosen[name], errors="coerce") for name in chosen], np.float64)
    bad = np.argwhere(~np.isfinite(values.T))
    if len(bad):
        row, column = bad[0]
        name = chosen.columns[column]
        where = (
            f"row {chosen.index[row] + (1 if names is None else 2)}, column {name if names else column + 1}"
        )
        raise DataError(path, f"{where}: must be a finite number, got {str(chosen.iloc[row, column])[:40]!r}")
    return values


def _listed(names: Iterable[object]) -> str:
    texts = [str(name) for name in names]
    return ",".join(texts[:6]) + ",…" * (len(texts) > 6)


def check_parquet(source: Path | BinaryIO | pa.NativeFile, where: Path | str) -> None:
    """Raise a `DataError` if it is not Parquet, or unpacks to more than `MOST_ROWS` rows or `MOST_BYTES` bytes."""
    with decoding(where, "not a readable Parquet file"):
        facts = pq.read_metadata(source)
        unpacked = sum(facts.row_group(i).total_byte_size for i in range(facts.num_row_groups))
    if facts.num_rows > MOST_ROWS or unpacked > MOST_BYTES:
        raise DataError(
            where,
            f"must have at most {MOST_ROWS} rows and {MOST_BYTES // MIB} MiB, "
            f"got {facts.num_rows} and {unpacked / MIB:.0f} MiB",
        )


def read_parquet(source: Path | pa.NativeFile, name: str = "") -> pa.Table:
    """Return a table, from a path or from a file of this ``name``; errors as `check_parquet`."""
    where = name or source
    check_parquet(source, where)
    with decoding(where, "not a readable Parquet file"):
        return pq.read_table(source)
