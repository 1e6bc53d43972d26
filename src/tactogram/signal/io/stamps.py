"""Calendar time stamps in tables, as ISO 8601 writes them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime

_STAMP = re.compile(r"\d{4}-?\d\d-?\d\d[T ]\d\d:?\d\d.*")


def parse_stamp(cell: object) -> datetime | None:
    """Return the instant in a cell, to 1 us: ``2026-05-04T10:11:12.345+02:00``, ``2026/05/04 10:11:12``; else None."""
    if isinstance(cell, datetime):
        return cell
    text = str(cell).strip().replace("/", "-")
    if not _STAMP.fullmatch(text):
        return None
    try:
        return datetime.fromisoformat(text)
    except ValueError:
        return None


def stamp_columns(rows: Sequence[Sequence[object]]) -> frozenset[int]:
    """Return the columns that hold calendar time stamps in all of the first rows."""
    width = min((len(row) for row in rows), default=0)
    return frozenset(i for i in range(width) if all(parse_stamp(row[i]) for row in rows))


class StampClock:
    """Seconds after the first of the stamps that it is called with; a ValueError for anything else."""

    def __init__(self) -> None:
        self._first: datetime | None = None

    def __call__(self, cell: object) -> float:
        """Return the seconds of a stamp after the first; its time zone, or its lack of one, must be as there."""
        stamp = parse_stamp(cell)
        if stamp is None:
            raise ValueError(f"expected a time stamp, got {cell!r}")
        if self._first is None:
            self._first = stamp
        if (stamp.tzinfo is None) != (self._first.tzinfo is None):
            raise ValueError(f"expected a time stamp {'with' if self._first.tzinfo else 'without'} time zone")
        return (stamp - self._first).total_seconds()
