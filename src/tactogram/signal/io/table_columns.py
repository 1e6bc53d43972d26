"""Cells of a table as columns: numbers with points or commas, grouped digits, units behind numbers, stamps."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, one_line
from tactogram.signal.io.content import Column
from tactogram.signal.io.stamps import is_stamp
from tactogram.signal.io.table_head import DECIMAL_COMMA, MISSING, NUMBER_WITH_UNIT, is_missing, is_number

MOST_FOOTER = 10
"""Rows below a table that may summarise it."""
MOST_MISSING = 0.8
"""Share of cells without a number above which a column without a heading is none."""
_SNIFFED = 200
_CALENDAR = re.compile(
    r"((?:19|20)\d\d)(0[1-9]|1[0-2])([0-2]\d|3[01])([01]\d|2[0-3])([0-5]\d)([0-5]\d)(\d{3}|)"
)
_MAYBE_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2},\d{3}")
_THOUSANDS = re.compile(r"[-+]?\d{1,3}(?:,\d{3})+\.\d+")
_DOTTED_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(?:\.\d{3})+")
MISSING_FORMS = sorted({form for cell in MISSING for form in (cell, cell.upper(), cell.title(), "NaN")})


def text_columns(
    lines: Sequence[str], sample: Sequence[str], width: int, separator: str
) -> tuple[list[Column], list[str | None]]:
    """Return the columns of lines of equal width, and the unit behind the numbers of each, if they have one.

    ``sample`` are the cells of the first lines.
    """
    import pandas as pd

    commas = any(DECIMAL_COMMA.fullmatch(cell) for cell in sample)
    dotted = [cell for cell in sample if "." in cell and is_number(cell)]
    thousands = "," if any(_THOUSANDS.fullmatch(cell) for cell in sample) else None
    if commas and dotted and all(_DOTTED_THOUSANDS.fullmatch(cell) for cell in dotted):
        dotted, thousands = [], "."
    text = "\n".join(line.rstrip(" " if separator == "\t" else None) for line in lines)
    try:
        frame = pd.read_csv(
            io.StringIO(text),
            sep=r"\s+" if separator == " " else separator,
            header=None,
            names=[*range(width + 1)],
            index_col=False,
            decimal="," if commas and not dotted else ".",
            thousands=thousands,
            skipinitialspace=True,
            keep_default_na=False,
            na_values=MISSING_FORMS,
            skip_blank_lines=False,
            low_memory=False,
        )
    except (ValueError, pd.errors.ParserError) as error:
        raise DataError(f"not a table: {one_line(error)}") from None
    pairs = [_column(frame[i].to_numpy()) for i in range(width)]
    return [column for column, _ in pairs], [unit for _, unit in pairs]


def _column(values: NDArray[np.generic]) -> tuple[Column, str | None]:
    if values.dtype.kind == "i" and (dated := _calendar_digits(values)) is not None:
        return dated, None
    if values.dtype.kind in "fiub":
        return values.astype(np.float64), None
    return with_unit([None if value != value else str(value).strip() for value in values])


def converted(cells: Sequence[object]) -> Column:
    """Return cells as float64 if all that are not missing are numbers, else as objects."""
    if all(is_missing(cell) or is_number(cell) for cell in cells):
        return np.array([np.nan if is_missing(cell) else float(str(cell)) for cell in cells])
    column = np.empty(len(cells), dtype=object)
    column[:] = [None if is_missing(cell) else cell for cell in cells]
    return column


def is_empty(column: Column) -> bool:
    """Return whether most cells are missing, as where an oscilloscope writes its settings beside the first rows."""
    missing = [cell is None for cell in column] if column.dtype == object else np.isnan(column)
    return float(np.mean(missing)) > MOST_MISSING


def footer_of(columns: Sequence[Column]) -> int:
    """Return how many of the last rows hold words where all others have numbers: ``Mean``, ``Max``, a remark."""
    rows = 0
    for column in columns:
        if column.dtype != object or len(column) < 3 * MOST_FOOTER:
            continue
        odd = [i for i, cell in enumerate(column) if cell is not None and not is_number(cell)]
        if odd and odd[0] >= len(column) - MOST_FOOTER and not is_stamp(column[odd[0]]):
            rows = max(rows, len(column) - odd[0])
    return rows


def start_and_rate(columns: Sequence[Column]) -> float | None:
    """Return the rate in Hz if all columns begin with the same second since 1970 and, below, the same rate."""
    if not columns or any(column.dtype == object or len(column) < 3 for column in columns):
        return None
    start, rate = float(columns[0][0]), float(columns[0][1])
    alike = all(column[0] == start and column[1] == rate for column in columns)
    return rate if alike and start > 1e9 and 1 <= rate <= 1e5 else None


def _calendar_digits(values: NDArray[np.generic]) -> Column | None:
    """Return whole numbers that spell date and time (``20260102102345000``) as stamps."""
    texts = [str(value) for value in values[:20]]
    if not texts or len(texts[0]) not in (14, 17) or not all(map(_CALENDAR.fullmatch, texts)):
        return None
    column = np.empty(len(values), dtype=object)
    column[:] = [_CALENDAR.sub(r"\1-\2-\3 \4:\5:\6.\g<7>0", str(value)) for value in values]
    return column


def with_unit(cells: Sequence[str | None]) -> tuple[Column, str | None]:
    """Return cells as numbers if each has the same unit behind it, or a decimal comma where others have points."""
    filled = [cell for cell in cells if cell]
    numeric = bool(filled) and all(is_number(cell) or DECIMAL_COMMA.fullmatch(cell) for cell in filled)
    if numeric and not all(_MAYBE_THOUSANDS.fullmatch(cell) for cell in filled if "," in cell):
        return converted([cell and cell.replace(",", ".") for cell in cells]), None
    units = {match and match[2] for cell in filled[:_SNIFFED] for match in [NUMBER_WITH_UNIT.fullmatch(cell)]}
    if len(units) == 1 and None not in units and not any(map(is_stamp, filled[:3])):
        matches = [NUMBER_WITH_UNIT.fullmatch(cell or "") for cell in cells]
        if all(match or not cell for match, cell in zip(matches, cells, strict=True)):
            return np.array([float(m[1].replace(",", ".")) if m else np.nan for m in matches]), units.pop()
    return converted(cells), None
