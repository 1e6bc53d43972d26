"""Clocks of a table: the columns of time stamps, which of them is taken, and in what unit it is."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, Remedy
from tactogram.signal.io.content import RawTable
from tactogram.signal.io.stamps import stamp_kind
from tactogram.signal.io.vocabulary import Heading, heading, headings_of, time_unit_of, words_of
from tactogram.signal.units import parse_seconds, split_heading

NONE = "none"
"""Name of no column: the time stamps are not to be used."""
EPOCHS = (
    *(
        ("ns", 9e17, 1e19, "1970"),
        ("us", 1e14, 1e17, "1970"),
        ("ms", 1e11, 1e14, "1970"),
        ("s", 1e9, 1e10, "1970"),
    ),
    *(("100 ns", 6e17, 9e17, "the year 1"), ("100 ns", 1.2e17, 2e17, "1601")),
    *(("d", 3e4, 7e4, "1900"), ("d", 7e5, 8e5, "the year 0")),
)
"""Units by the size of stamps since a year, as of Unix, .NET, Windows, Excel and MATLAB."""
STEPS = (("s", 2e-5, 0.1), ("ms", 0.1, 50.0), ("us", 50.0, 5e4), ("ns", 5e4, 5e7))
"""Units by the step between stamps without any: rates of 20 Hz to 50 kHz. Ours."""
BOARD_STEPS = (STEPS[0], ("ms", 0.1, 250.0), ("us", 50.0, 2e6))
"""Of a board, which counts no ns and may be slow: a load cell has 10 Hz."""
_NEAR = 0.1
"""Relative difference between a stated rate and that of stamps in the right unit."""
_MEASURED = 0.99
"""Share of steps that go forward in a clock."""


@dataclass(frozen=True)
class Clock:
    """Column of time stamps: ``seconds`` per unit of numbers, None of dates and times of day."""

    place: int
    unit: str
    seconds: float | None
    note: str | None = None


def clocks_of(table: RawTable, headings: Sequence[Heading]) -> dict[int, str | None]:
    """Return the columns that may be time stamps, with the unit that heading or form states, None if neither does."""
    clocks: dict[int, str | None] = {}
    for i, (each, column) in enumerate(zip(headings, table.columns, strict=True)):
        if column.dtype == object:
            cells = [cell for cell in column[:50] if cell is not None]
            if kind := stamp_kind(cells):
                clocks[i] = kind
        elif each.is_clock and _forward(
            column, 0.5 if table.named and not each.sensor.count(" ") else _MEASURED
        ):
            clocks[i] = time_unit_of(each)
    values = [i for i, each in enumerate(headings) if each.words == ["x", "value"]]
    if not clocks and values and not any(each.words == ["y", "value"] for each in headings):  # LabVIEW
        clocks |= {i: None for i in values if table.columns[i].dtype != object and _forward(table.columns[i])}
    if not clocks and len(table.columns) > 1 and (table.numbered or not headings[0].name):
        for i, column in enumerate(table.columns[:3]):
            steps = np.diff(column[np.isfinite(column)]) if column.dtype != object else np.array([])
            if len(steps) < 2 or float(np.mean(steps == 1)) > 0.9 or float(np.mean(steps == 0)) == 1:
                continue  # words, a counter, a constant
            if _forward(column) and (not table.brief or ticks_evenly(column)):
                clocks[i] = None
            break
    return clocks


def split_by_clocks(table: RawTable) -> list[RawTable]:
    """Return a table with a clock before each channel, at several rates, as a table of each clock.

    Clocks that are alike, or are not alternately with their channels, leave it as it is.
    """
    headings = headings_of(table.headings, table.units)
    clocks = [i for i in clocks_of(table, headings) if table.columns[i].dtype != object]
    named = {re.sub(r"\d+", "", headings[i].name.lower()) for i in clocks}
    if len(clocks) < 2 or clocks[0] != 0 or len(named) > 1 or np.any(np.diff([*clocks, len(headings)]) < 2):
        return [table]
    first = table.columns[0]
    if all(np.array_equal(first, table.columns[i], equal_nan=True) for i in clocks[1:]):
        return [table]
    tables: dict[bytes, list[int]] = {}
    for start, end in zip(clocks, [*clocks[1:], len(headings)], strict=True):
        places = tables.setdefault(table.columns[start].tobytes(), [start])
        places += range(start + 1, end)
    return [_columns_of(table, places) for places in tables.values()]


def _columns_of(table: RawTable, places: Sequence[int]) -> RawTable:
    """Return some columns of a table as far as the first of them goes."""
    length = int(np.flatnonzero(np.isfinite(table.columns[places[0]].astype(np.float64)))[-1]) + 1
    return replace(
        table,
        headings=tuple(table.headings[i] for i in places),
        columns=tuple(table.columns[i][:length] for i in places),
        units=tuple(table.units[i] for i in places) if table.units else (),
        groups=tuple(table.groups[i] for i in places) if table.groups else (),
        rows=table.rows[:length],
    )


def with_whole_clock(table: RawTable) -> RawTable:
    """Return a table whose columns of hours, minutes, seconds or a fraction, side by side, are one clock in seconds."""
    names = [words_of(text) for text in table.headings]
    numbers = [column.dtype != object for column in table.columns]
    units = [
        parse_seconds(words[-1]) if words and number else None
        for words, number in zip(names, numbers, strict=True)
    ]
    for i, unit in enumerate(units):
        end, seconds, last = i + 1, np.zeros(0), unit
        while last and end < len(units) and (finer := units[end]) and names[end][:-1] == names[i][:-1]:
            column = table.columns[end].astype(np.float64)
            if (
                not 0
                <= np.nanmin(column)
                <= np.nanmax(column) * finer
                < last
                <= 1000 * finer * (1e6 if last == 1 else 1)
            ):
                break
            whole = table.columns[i].astype(np.float64)
            seconds = (seconds if len(seconds) else (whole - whole[0]) * (unit or 1)) + column * finer
            end, last = end + 1, finer
        if len(seconds):
            heading = " ".join([*names[i][:-1], "time", "[s]"])
            return replace(
                table,
                headings=(*table.headings[:i], heading, *table.headings[end:]),
                columns=(*table.columns[:i], seconds, *table.columns[end:]),
                units=(*table.units[:i], None, *table.units[end:]) if table.units else (),
                groups=(*table.groups[:i], "", *table.groups[end:]) if table.groups else (),
            )
    return table


def forward(table: RawTable) -> RawTable:
    """Return a table whose rows stand in descending order of time the other way round, with a note."""
    for text, column in zip(table.headings, table.columns, strict=True):
        if column.dtype == object or not heading(text).is_clock or not time_unit_of(heading(text)):
            continue
        if len(column) > 3 and bool((np.diff(column) < 0).all()):
            return replace(
                table,
                columns=tuple(each[::-1] for each in table.columns),
                rows=[*table.rows][::-1],
                notes=(*table.notes, f"rows in descending order of {text}: reversed"),
            )
    return table


def choose_clock(
    table: RawTable,
    headings: Sequence[Heading],
    clocks: Mapping[int, str | None],
    *,
    time: str | None,
    rate: float | None,
) -> Clock | None:
    """Return the time stamps: those of the column ``time``, else the clock with the fewest repeated stamps."""
    if table.description is not None:
        if len(table.headings) == len(table.description.axes):
            return None
        return Clock(0, headings[0].unit or "s", parse_seconds(headings[0].unit or "s") or 1.0)
    if time == NONE:
        return None
    if time is not None:
        chosen, unit = _named(time, table, headings)
        unit = unit or clocks.get(chosen) or time_unit_of(headings[chosen])
        if table.columns[chosen].dtype == object:
            kind = stamp_kind([cell for cell in table.columns[chosen][:50] if cell is not None])
            return Clock(chosen, kind or "date and time", None)
        return _with_unit(chosen, unit, table, rate)
    if not clocks:
        _ask(table, headings, rate)
        return None

    def rank(index: int) -> tuple[bool, float, bool, bool, bool, int]:
        column = table.columns[index]
        dated = column.dtype == object
        if dated:
            repeated = len({*map(str, column)}) < (1 - 0.05) * len(column)
        else:
            repeated = float(np.mean(np.diff(column) == 0)) > 0.05 if len(column) > 1 else False
        still = len({*map(str, column[:50])}) == 1
        return (
            still,
            float(repeated),
            dated,
            clocks[index] is None,
            "header" not in headings[index].words,
            index,
        )

    best = min(clocks, key=rank)
    if table.columns[best].dtype == object:
        return Clock(best, str(clocks[best]), None)
    spelled = headings[best].unit
    if clocks[best] is None and spelled and re.fullmatch(r"[a-zµ]{1,3}", spelled):
        raise DataError(
            f"unit {spelled!r} of time column {table.headings[best]!r} is not known",
            remedy=Remedy("say it, e.g.", "time", f"{headings[best].name} [ms]"),
        )
    return _with_unit(best, clocks[best], table, rate)


def _with_unit(index: int, unit: str | None, table: RawTable, rate: float | None) -> Clock | None:
    name = table.headings[index]
    if unit is not None:
        return Clock(index, unit, parse_seconds(unit))
    column = table.columns[index].astype(np.float64)
    values = column[np.isfinite(column)]
    steps = np.abs(np.diff(values))
    typical = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    if typical == 0:
        if len(values) > 1:
            raise DataError(f"time column {name!r} must go forward, its stamps are all {values[0]:g}")
        raise DataError(f"expected two rows of numbers or more, got {len(values)}")
    size = float(np.abs(values).max(initial=0.0))
    for candidate, low, high, since in EPOCHS:
        if low <= size < high and 1e-6 <= typical * (parse_seconds(candidate) or 1) <= 1.0:
            return Clock(
                index, candidate, parse_seconds(candidate), f"{name} is in {candidate} since {since}"
            )
    ticks = any(word.startswith("tick") for word in words_of(name))
    ranges = BOARD_STEPS if table.brief else STEPS
    fitting = [candidate for candidate, low, high in ranges if low <= typical <= high and not ticks]
    counts = typical == 1 and float(np.std(steps)) == 0
    if rate is not None:
        near = {c: abs(np.log(typical * (parse_seconds(c) or 1) * rate)) for c, *_ in STEPS}
        fitting = [c for c, off in near.items() if off < _NEAR]
        if counts and not fitting:
            return None
    if len(fitting) != 1 or (counts and rate is None):
        rates = {c: 1 / (typical * (parse_seconds(c) or 1)) for c in ("s", "ms", "us", "ns", "d")}
        likely = [c for c in rates if 1 <= rates[c] <= 1e6]
        listed = ", ".join(f"{rates[c]:g} Hz in {c}" for c in likely)
        raise DataError(
            f"time column {name!r} without unit goes in steps of {typical:g} ({listed})",
            remedy=(
                Remedy("say its unit,", "time", f"{name} [{likely[len(likely) // 2] if likely else 's'}]"),
                Remedy("if it only counts, the rate, e.g.", "rate", 100),
            ),
        )
    unit = fitting[0]
    hertz = f"{1 / (typical * (parse_seconds(unit) or 1)):g} Hz"
    note = None if unit == "s" else f"{name} without unit taken as {unit}: {hertz}"
    if not table.named:
        note = f"column {name} rises: taken for the time, in {unit}: {hertz}"
    return Clock(index, unit, parse_seconds(unit), note)


def _ask(table: RawTable, headings: Sequence[Heading], rate: float | None) -> None:
    """Raise a `DataError` if a column that is named as an axis looks like time stamps, and nothing else does."""
    if rate is not None or table.rate is not None or not table.named:
        return
    for each, column in zip(headings, table.columns, strict=True):
        if (
            each.is_clock
            and each.axis is None
            and column.dtype != object
            and len(column) > 1
            and float(np.ptp(column)) == 0
        ):
            raise DataError(
                f"time stands still: all {len(column)} stamps in {each.text!r} are {column[0]:g}",
                remedy=Remedy("give the rate instead, e.g.", "rate", 1000),
            )
    for each, column in zip(headings, table.columns, strict=True):
        if each.axis is None or each.quantity is not None or column.dtype == object or len(column) < 3:
            continue
        steps = np.diff(column)
        if (steps > 0).all() and float(np.ptp(steps)) <= 0.01 * abs(float(steps.mean())):
            others = [other.name for other in headings if other is not each]
            raise DataError(
                f"column {each.name!r} goes in even steps: is it the time or an axis?",
                remedy=(
                    Remedy("state the time,", "time", f"{each.name} [s]"),
                    Remedy("with a rate the axes,", "axes", ",".join([each.name, *others])),
                ),
            )


def _named(time: str, table: RawTable, headings: Sequence[Heading]) -> tuple[int, str | None]:
    """Return the place of a column, and the unit stated behind its name."""
    name, unit = split_heading(time)
    for text, stated in ((time, None), (name, unit)):
        for candidates in (table.headings, [each.name for each in headings]):
            if text in candidates:
                return candidates.index(text), stated
        if text.isdigit() and 1 <= int(text) <= len(headings):
            return int(text) - 1, stated
    raise DataError(f"no column {time!r}, there are {', '.join(table.headings)}")


def ticks_evenly(values: NDArray[np.generic]) -> bool:
    """Return whether most steps are alike, or a straight line fits, as those of a clock do; of a few numbers."""
    steps = np.diff(values[np.isfinite(values)].astype(np.float64))
    middle = float(np.median(steps)) if len(steps) else 0.0
    if middle > 0 and float(np.median(np.abs(steps - middle))) <= middle / 4:
        return True
    line = np.arange(len(steps) + 1.0)
    return bool(steps.any()) and float(np.corrcoef(line, np.cumsum([0, *steps]))[0, 1]) > 0.995


def _forward(column: NDArray[np.generic], share: float = _MEASURED) -> bool:
    """Return whether a share of the steps goes forward as time does, or all but a few restarts."""
    values = column[np.isfinite(column)].astype(np.float64)
    if len(values) < 2:
        return len(values) == 1
    steps = np.diff(values)
    back = int(np.count_nonzero(steps < 0))
    allowed = max(3 if len(steps) > 60 else 0, (1 - share) * len(steps))
    return values.max() > values.min() and back <= allowed
