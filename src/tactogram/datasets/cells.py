"""Table cells: values, or an error that names the cell."""

from __future__ import annotations

import math

from tactogram.errors import DataError


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
