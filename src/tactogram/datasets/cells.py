"""What stands in a cell of a table: read, or refused with the place where it stands."""

from __future__ import annotations

import math

from tactogram.errors import DataError


def finite_number(where: str, name: str, text: str | None) -> float:
    """Return a cell's text as a finite number.

    Parameters
    ----------
    where : str
        File and row, as an error begins.
    name : str
        Of the column.
    text : str or None
        None where the row ended before.

    Raises
    ------
    DataError
        If it is no number, or not a finite one.
    """
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise DataError(f"{where}: {name} must be a number, got {text!r}")
    return value
