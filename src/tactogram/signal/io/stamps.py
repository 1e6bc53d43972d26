"""Time stamps in tables that are no plain numbers: dates with times in the usual orders, and times of day."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime, time, timedelta

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError

CALENDAR, CLOCK = "date and time", "time of day"
"""Units of such time stamps in `ColumnUse`."""
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_STAMP = re.compile(
    r"""\s*(?:(?:[A-Za-z]{3},?\ +)?
    (?:(?P<a>\d{4}|\d{1,2})[-/. ]\ ?(?P<b>\d{1,2}|[A-Za-z]{3,9})[-/. ],?\ ?(?P<c>\d{4}|\d{1,2})
       |(?P<word>(?i:jan|feb|mar|apr|may|jun|jul|aug|sep|oct|nov|dec)[a-z]{0,6})\ +
        (?P<wordday>\d{1,2}),?(?:\ (?P<wordyear>\d{4}))?
       |(?P<year>(?:19|20)\d\d)(?P<month>\d\d)(?P<day>\d\d))(?=[T_\ ,;]|$)[T_\ ,;]*)?
    (?:(?P<hour>\d{1,2})(?P<dot>[:.h-])(?P<minute>\d{1,2})(?:(?P<point>[:.m-])(?P<second>\d{1,2}))?(?:[.,:_](?P<fraction>\d{1,9}))?
       \s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*(?P<zone>Z|UTC|GMT|[+-]\d{2}:?\d{2})?(?:\ (?P<lastyear>\d{4}))?)?\s*""",
    re.VERBOSE,
)
_COMPACT = re.compile(r"(\d{8}T\d\d)(\d\d)(\d\d)")
_DAY_S = 86_400.0


def is_stamp(cell: object) -> bool:
    """Return whether a cell holds a date, a date with a time, or a time of day, and is no plain number."""
    if isinstance(cell, datetime | time | timedelta):
        return True
    match = _match(cell) if isinstance(cell, str) else None
    return match is not None and any(
        (*match.group("a", "year", "word"), ":" in match.string and match["minute"])
    )


def stamp_kind(cells: Sequence[object]) -> str | None:
    """Return `CALENDAR` or `CLOCK` if all cells are such stamps; a column of dates without times is neither."""
    if not cells or not all(is_stamp(cell) for cell in cells):
        return None
    if all(_has_time(cell) for cell in cells):
        return CALENDAR if any(_has_date(cell) for cell in cells) else CLOCK
    return None


def is_date(cell: object) -> bool:
    """Return whether a cell holds a date alone."""
    return is_stamp(cell) and not _has_time(cell)


def stamp_seconds(cells: NDArray[np.object_], where: str, rows: Sequence[int]) -> NDArray[np.float64]:
    """Return the seconds of each stamp after the first, NaN where there is none.

    A time of day that is more than half a day earlier than the one before is of the next day. Of ``3/4/2026`` the day
    comes first, unless a number above 12 says otherwise. A `DataError` names ``where`` and the row of a cell that is
    no stamp, or not like the first.
    """
    instants = np.full(len(cells), np.nan)
    kinds: set[tuple[bool, bool]] = set()
    first_day: int | None = None
    parts = [_parts(cell) for cell in cells]
    month_first = any(part and part[0] and part[0][1] > 12 for part in parts)
    for i, part in enumerate(parts):
        if part is None:
            if cells[i] is None or not str(cells[i]).strip() or cells[i] != cells[i]:
                continue
            raise DataError(where.format(rows[i]), f"expected a time stamp, got {cells[i]!r}")
        date, seconds, zone = part
        kinds.add((date is not None, zone is not None))
        if len(kinds) > 1:
            raise DataError(where.format(rows[i]), f"expected a time stamp like the first, got {cells[i]!r}")
        days = 0
        if date is not None:
            year, second, third = date
            day, month = (third, second) if year > 99 else (0, 0)
            if year <= 99:  # day, month, year or month, day, year
                day, month, year = (year, second, third) if not month_first else (second, year, third)
                year += 2000 * (year < 100)
            try:
                days = datetime(year, month, day).toordinal()
            except ValueError:
                raise DataError(where.format(rows[i]), f"expected a date, got {cells[i]!r}") from None
        first_day = days if first_day is None else first_day
        instants[i] = (days - first_day) * _DAY_S + seconds - (zone or 0)
    known = np.flatnonzero(np.isfinite(instants))
    if kinds == {(False, False)} or kinds == {(False, True)}:
        steps = np.diff(instants[known])
        instants[known[1:]] -= _DAY_S * np.cumsum(np.round(steps / _DAY_S))
    return instants - instants[known[0]] if len(known) else instants


def _match(text: str) -> re.Match[str] | None:
    text = _COMPACT.sub(r"\1:\2:\3", re.sub(r"^\d+ days?,? +", "", text.strip()))
    if "年" in text:
        text = (
            re.sub("年|月", "-", text)
            .replace("日", " ")
            .replace("時", ":")
            .replace("分", ":")
            .replace("秒", "")
            .strip()
        )
    return None if not text or _is_number(text) else _STAMP.fullmatch(text)


def _is_number(text: str) -> bool:
    try:
        float(text.replace(",", "."))
    except ValueError:
        return False
    return True


def _has_date(cell: object) -> bool:
    if isinstance(cell, datetime | time | timedelta):
        return isinstance(cell, datetime)
    match = _match(str(cell))
    return bool(match and (match["a"] or match["year"] or match["word"]))


def _has_time(cell: object) -> bool:
    if isinstance(cell, datetime | time | timedelta):
        return True
    match = _match(str(cell))
    return bool(match and match["hour"])


def _parts(cell: object) -> tuple[tuple[int, int, int] | None, float, float | None] | None:
    """Return date (as written, the year first if it has four digits), seconds of the day and zone (s) of a stamp."""
    if isinstance(cell, timedelta):
        return None, cell.total_seconds(), None
    if isinstance(cell, datetime | time):
        seconds = 3600 * cell.hour + 60 * cell.minute + cell.second + 1e-6 * cell.microsecond
        date = (cell.year, cell.month, cell.day) if isinstance(cell, datetime) else None
        east = cell.utcoffset() if isinstance(cell, datetime) else None
        return date, seconds, None if east is None else east.total_seconds()
    match = _match(str(cell)) if isinstance(cell, str) else None
    if match is None or not is_stamp(cell):
        return None
    date = None
    if match["year"]:
        date = (int(match["year"]), int(match["month"]), int(match["day"]))
    elif match["word"]:
        if (word := match["word"][:3].lower()) not in _MONTHS:
            return None
        year = match["wordyear"] or match["lastyear"] or 1970
        date = (int(year), _MONTHS.index(word) + 1, int(match["wordday"]))
    elif match["a"]:
        middle = match["b"]
        named = middle[:3].lower() if not middle.isdigit() else ""
        if named and named not in _MONTHS:
            return None
        date = (int(match["a"]), _MONTHS.index(named) + 1 if named else int(middle), int(match["c"]))
        if named and date[0] <= 99:  # 4-May-2026
            date = (date[2] if date[2] > 99 else 2000 + date[2], date[1], date[0])
    seconds = 0.0
    if match["hour"]:
        hour, minute, second = (int(match[name] or 0) for name in ("hour", "minute", "second"))
        fraction = float(f"0.{match['fraction'] or 0}")
        if (
            match["point"] == "." and match["dot"] == ":"
        ):  # minutes, seconds and a fraction, as Excel shows them
            hour, minute, second, fraction = 0, hour, minute, float(f"0.{match['second']}")
        elif match["second"] is None and match["fraction"]:
            hour, minute, second = 0, hour, minute
        if half := match["half"]:
            hour = hour % 12 + (12 if half[0] in "pP" else 0)
        if hour > 24 or minute > 59 or second > 60:
            return None
        seconds = 3600.0 * hour + 60 * minute + second + fraction
    offset: float | None = None
    if zone := match["zone"]:
        digits = re.sub(r"\D", "", zone).ljust(4, "0")
        offset = (1 if zone[0] != "-" else -1) * (3600.0 * int(digits[:2]) + 60 * int(digits[2:]))
    return date, seconds, offset
