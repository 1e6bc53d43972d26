"""Table cells: values, or an error that names the cell."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tactogram.errors import DataError, one_line


def finite_number(where: object, name: str, text: str | None) -> float:
    """Return the text of a table cell as a finite number; errors name ``where`` (file and row) and the column."""
    stripped = (text or "").strip()
    try:
        value = float(stripped)
    except ValueError:
        raise DataError(f"{where}: {name} must be a number, got {stripped!r}") from None
    if not math.isfinite(value):
        raise DataError(f"{where}: {name} must be a finite number, got {stripped!r}")
    return value


def number_columns(
    path: Path, names: Sequence[str] | None = None, *, separator: str = ",", least: int = 1
) -> NDArray[np.float64]:
    """Return columns of a CSV, XLSX or Parquet file by their headings, float64, shape (column, row).

    Without ``names`` the file has no heading, and all columns are returned. A cell that is no finite number is a
    `DataError`, as are a missing column and fewer than ``least`` rows.
    """
    head = None if names is None else 0
    try:
        match path.suffix.lower():
            case ".xlsx":
                table = pd.read_excel(path, header=head, engine="openpyxl")
            case ".parquet":
                table = pd.read_parquet(path)
            case _:
                table = pd.read_csv(path, header=head, sep=separator, index_col=False, skip_blank_lines=False)
                table = table.dropna(how="all")
    except Exception as error:  # pandas and the readers below it raise whatever a damaged file leads to
        raise DataError(f"{path}: not a readable table: {one_line(error)}") from error
    if lacking := [name for name in names or () if name not in table]:
        raise DataError(
            f"{path}: needs columns {_listed(names or ())}, lacks {_listed(lacking)}, has {_listed(table.columns)}"
        )
    chosen = table if names is None else table[list(names)]
    if len(chosen) < least:
        raise DataError(f"{path}: must have {least} or more rows of samples, got {len(chosen)}")
    values = np.array([pd.to_numeric(chosen[name], errors="coerce") for name in chosen], np.float64)
    bad = np.argwhere(~np.isfinite(values.T))
    if len(bad):
        row, column = bad[0]
        name = chosen.columns[column]
        where = (
            f"row {chosen.index[row] + (1 if names is None else 2)}, column {name if names else column + 1}"
        )
        raise DataError(
            f"{path}: {where}: must be a finite number, got {str(chosen.iloc[row, column])[:40]!r}"
        )
    return values


def _listed(names: Iterable[object]) -> str:
    texts = [str(name) for name in names]
    return ",".join(texts[:6]) + ",…" * (len(texts) > 6)
