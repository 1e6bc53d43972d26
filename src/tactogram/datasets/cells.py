"""Table cells: values, or an error that names the cell."""

from __future__ import annotations

import math

from tactogram.errors import DataError


def finite_number(where: object, name: str, text: str | None) -> float:
    """Return a cell's text as a finite number.

    Parameters
    ----------
    where : object
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
    said = (text or "").strip()
    try:
        value = float(said)
    except ValueError:
        raise DataError(f"{where}: {name} must be a number, got {said!r}") from None
    if not math.isfinite(value):
        raise DataError(f"{where}: {name} must be a finite number, got {said!r}")
    return value
