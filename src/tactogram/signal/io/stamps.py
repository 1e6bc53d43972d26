"""Time stamps in tables that are no plain numbers: dates with times, as ISO 8601 writes them, and times of day."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime, time

CALENDAR, CLOCK = "date and time", "time of day"
"""Units of such time stamps in `ColumnUse`."""
_STAMP = re.compile(r"\d{4}-?\d\d-?\d\d[T ]\d\d:?\d\d.*")
_TIME_OF_DAY = re.compile(r"([01]?\d|2[0-3]):([0-5]\d):([0-5]\d(?:[.,]\d{1,9})?)")
_DAY_S = 86_400.0


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


def parse_time_of_day(cell: object) -> float | None:
    """Return the seconds after midnight of a time in a cell (``12:03:04.123``, ``9:03:04,5``); else None."""
    if isinstance(cell, time):
        return 3600 * cell.hour + 60 * cell.minute + cell.second + 1e-6 * cell.microsecond
    found = _TIME_OF_DAY.fullmatch(str(cell).strip())
    if found is None:
        return None
    return 3600 * int(found[1]) + 60 * int(found[2]) + float(found[3].replace(",", "."))


def is_stamp(cell: object) -> bool:
    """Return whether a cell holds a date with a time, or a time of day."""
    return parse_stamp(cell) is not None or parse_time_of_day(cell) is not None


def stamp_columns(rows: Sequence[Sequence[object]]) -> dict[int, str]:
    """Return the columns that hold such time stamps in all of the first rows, with their unit."""
    width = min((len(row) for row in rows), default=0)
    found = {}
    for i in range(width):
        if all(parse_stamp(row[i]) for row in rows):
            found[i] = CALENDAR
        elif all(parse_time_of_day(row[i]) is not None for row in rows):
            found[i] = CLOCK
    return found


class StampClock:
    """Seconds after the first of the stamps that it is called with; a ValueError for anything else.

    A time of day that is more than half a day earlier than the one before is of the next day.
    """

    def __init__(self) -> None:
        self._first: datetime | float | None = None
        self._last = 0.0

    def __call__(self, cell: object) -> float:
        """Return the seconds of a stamp after the first; its time zone, or its lack of one, must be as there."""
        stamp = parse_stamp(cell) or parse_time_of_day(cell)
        if stamp is None:
            raise ValueError(f"expected a time stamp, got {cell!r}")
        first = self._first = stamp if self._first is None else self._first
        if isinstance(stamp, datetime) and isinstance(first, datetime):
            if (stamp.tzinfo is None) != (first.tzinfo is None):
                raise ValueError(f"expected a time stamp {'with' if first.tzinfo else 'without'} time zone")
            return (stamp - first).total_seconds()
        if isinstance(stamp, datetime) or isinstance(first, datetime):
            raise ValueError(f"expected a time stamp like the first, got {cell!r}")  # noqa: TRY004
        seconds = stamp - first
        seconds += _DAY_S * round((self._last - seconds) / _DAY_S)
        self._last = seconds
        return seconds
