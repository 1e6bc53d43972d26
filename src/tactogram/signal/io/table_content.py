"""Streams of a table: numbers and time stamps of its columns, once it is known what these hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, Message, Remedy
from tactogram.signal.io.clocks import forward, split_by_clocks, with_whole_clock
from tactogram.signal.io.content import IGNORED, ColumnUse, FileContent, RawTable, TableLayout, default_axes
from tactogram.signal.io.labels import LONGEST_STEP, cut, label_of_cell
from tactogram.signal.io.long_tables import split_by_sensor
from tactogram.signal.io.roles import StreamColumns, TableRoles, no_signal, rank_of, roles_of
from tactogram.signal.io.stamps import stamp_seconds
from tactogram.signal.io.table_head import is_number
from tactogram.signal.io.vocabulary import heading, headings_of
from tactogram.signal.timing import MOST_REPEATED, MOST_SPAN, steps_alike
from tactogram.signal.units import STANDARD_GRAVITY

MOST_HOLES = 0.05
"""Share of steps above which holes are no holes, but the times between blocks."""
MOST_OFF = 0.05
"""Relative difference of a stated rate and the time stamps that is worth a note."""
MARKERS = (-9999.0, -999.0, -99999.0, 9999.0, 99999.0, -999.25)
"""Numbers that programs write where they have none."""
MOST_LOOKED_AT = 2**20
"""Samples that tell whether numbers without a unit are counts."""
BY_VALUES = ("constant", "0 and 1 alone", "empty", "counter")
"""Reasons to leave out a column that its values give."""
LONG_AGO_S = 1e8
"""Time stamps beyond it are relative to the first, so that float64 keeps their microseconds."""


def table_contents(
    tables: Sequence[RawTable],
    *,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    rate: float | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> tuple[FileContent, ...]:
    """Return the streams of the tables in a file, that of the signal first; arguments and errors as `roles_of`."""
    contents: list[FileContent] = []
    problem: DataError | None = None
    left_out: list[str] = []
    parts = [part for whole in tables for part in split_by_sensor(with_whole_clock(whole))]
    parts = [part for whole in parts for part in split_by_clocks(forward(whole))]
    for whole in tables:
        if whole.rest is not None and not any(part is whole for part in parts):
            raise DataError(
                whole.path, "several sensors or clocks, or time in descending order, in a long table; cut it"
            )
    for table in parts:
        try:
            roles = roles_of(table, axes=axes, time=time, rate=rate, layouts=layouts, labelled=labelled)
        except DataError as error:
            problem = problem or DataError(table.path, error)
            left_out.append(f"left out: {', '.join(table.headings)} (rows of their own)")
            continue
        contents += [_content(table, roles, stream, rate) for stream in roles.streams]
    if not contents:
        raise problem or DataError("no columns of numbers")
    uses = tuple(use for content in {id(c.uses): c for c in contents}.values() for use in content.uses)
    notes = tuple(dict.fromkeys([*(note for content in contents for note in content.notes), *left_out]))
    if any(content.chosen or content.layout for content in contents):
        contents.sort(key=lambda content: not (content.chosen or content.layout))
    else:
        contents = _main_first(contents, tables[0])
    return (replace(contents[0], uses=uses, notes=notes), *contents[1:])


def _main_first(contents: Sequence[FileContent], table: RawTable) -> list[FileContent]:
    """Return the streams of several tables, that of the signal first; a `DataError` if two may be it."""
    if all(content.uses is contents[0].uses for content in contents):
        return [*contents]

    def rank(content: FileContent) -> tuple[bool, int]:
        return content.unit is None and "acceleration" not in content.stream, rank_of(content.stream)

    first, *others = sorted(contents, key=rank)
    alike = [
        content for content in others if content.uses is not first.uses and content.stream == first.stream
    ]
    alike = [first, *(content for content in alike if (content.unit is None) == (first.unit is None))]
    if len(alike) > 1:
        names = [[use.heading for use in content.uses if use.role in content.axes] for content in alike]
        what = first.stream.replace("_", " ") or "columns"
        raise DataError(
            table.path,
            f"which {what}, at rates of their own: {' or '.join(', '.join(each) for each in names)}?",
            remedy=Remedy("choose, e.g.", "axes", ",".join(names[0])),
        )
    return [first, *others]


def only_part(contents: Sequence[FileContent], part: int | None) -> tuple[FileContent, ...]:
    """Return the streams of a table without holes, or those of one of the ``part`` s between them, counted from 1.

    A `DataError` if there are several parts and none is chosen.
    """
    if part in (None, 1) and all(each.times is None or steps_alike(each.times) for each in contents):
        return tuple(contents)
    if contents[0].times is None:
        return tuple(contents)
    alike = [content for content in contents if content.rows == contents[0].rows]
    intervals = cut([replace(content, labels={}) for content in alike])
    if len(intervals) <= 1 and part in (None, 1):
        return tuple(contents)
    if part is None:
        first, second = intervals[:2]
        stop, start = first.contents[0].times, second.contents[0].times
        with np.errstate(over="ignore"):
            step = 0.0 if stop is None or start is None else start[0] - stop[-1]
        what = f"time goes back by {-step:.4g} s" if step < 0 else f"{step:.4g} s without samples"
        if len(intervals) > MOST_HOLES * len(contents[0].rows) + 2:
            raise DataError(
                f"time goes back or stands for long at {len(intervals) - 1} rows: these are not in the order of time",
                remedy=(Remedy("sort them"), Remedy("with a rate read them as they are,", "time", "none")),
            )
        longest = max(range(len(intervals)), key=lambda i: len(intervals[i].contents[0].rows)) + 1
        raise DataError(
            f"rows {first.rows[1]} to {second.rows[0]}: {what}; at most 3 missing samples are interpolated",
            remedy=Remedy(
                f"choose one of the {len(intervals)} parts between, e.g. the longest,", "part", longest
            ),
        )
    if not 1 <= part <= len(intervals):
        raise DataError(f"part must be 1 to {len(intervals)}, got {part}")
    return intervals[part - 1].contents


def _content(table: RawTable, roles: TableRoles, stream: StreamColumns, rate: float | None) -> FileContent:
    own = table.description is not None
    samples, times, rows, read = _numbers(table, roles, stream)
    notes = [*table.notes, *roles.notes, *read]
    if times is not None and roles.seconds is not None:
        times = _in_seconds(times, roles.seconds)
    labels = {role: [label_of_cell(cell) for cell in table.columns[i]] for role, i in roles.labels.items()}
    kept: NDArray[np.int64] | None = None
    if not own and times is not None and len(times) < 2:
        raise DataError(table.path, "one row of numbers is no signal")
    if times is not None and not own:
        if np.isnan(times[:-1]).mean() > MOST_HOLES:  # stamps of the first sample of each block alone
            times = _filled(times)
        missing = np.isnan(times)
        for values in samples:
            missing |= np.isnan(values)
        if missing.any() and not missing.all():
            kept = np.flatnonzero(~missing)
            samples, times = samples[:, kept], times[kept]
            labels = {role: [values[i] for i in kept] for role, values in labels.items()}
        times, note = _trusted(times, table, rate)
        notes += [note] if note else []
    numbered: Sequence[int] = rows if kept is None else [rows[i] for i in kept]
    known = table.rate if times is None or own else None
    if times is not None and table.rate is not None and _on_grid(times, table.rate):
        times, known = None, table.rate
    if note := unit_note(stream, roles.uses, samples[:, :MOST_LOOKED_AT]):
        notes.append(note)

    def place(axis: int, sample: int) -> str:
        column = roles.time if axis < 0 else stream.places[axis]
        return f"row {numbered[sample]}, column {table.headings[column or 0]!r}"

    return FileContent(
        samples=samples,
        axes=stream.axes if table.named or stream.layout else _unnamed_axes(len(samples), table),
        rate=known,
        times=None if table.description is not None else times,
        unit=table.description.unit if table.description else stream.unit,
        description=table.description,
        place=place,
        comment=table.comment,
        uses=roles.uses,
        layout=stream.layout,
        labels=labels,
        rows=numbered,
        stream=stream.name,
        chosen=stream.chosen,
        notes=tuple(notes),
    )


def _numbers(
    table: RawTable, roles: TableRoles, stream: StreamColumns
) -> tuple[
    NDArray[np.float32] | NDArray[np.float64], NDArray[np.float64] | None, Sequence[int], tuple[str, ...]
]:
    """Return the samples of a stream, its time stamps as they are (calendar stamps in s), numbers of rows, and notes.

    Those of a table in blocks are read now, into as much memory as they need.
    """
    if table.rest is None:
        return _part_numbers(table, roles, stream)
    if roles.labels:
        raise DataError(table.path, "columns of labels in a long table; cut it")
    samples = np.empty((len(stream.places), table.most_rows), np.float32)
    times = None if roles.time is None else np.empty(table.most_rows)
    numbers: list[Sequence[int]] = []
    notes: dict[str, None] = {}
    end = 0
    for part in chain([table], table.rest()):
        _check_alike(part, roles)
        values, stamps, rows, marked = _part_numbers(part, roles, stream)
        begin, end = end, end + len(part)
        samples[:, begin:end] = values
        if times is not None and stamps is not None:
            times[begin:end] = stamps
        numbers.append(rows)
        notes |= dict.fromkeys([*marked, *(part.notes if part is not table else ())])
    samples = samples[:, :end]
    samples.flags.writeable = False
    regular = all(isinstance(rows, range) for rows in numbers)
    every = range(numbers[0][0], numbers[-1][-1] + 1) if regular else np.concatenate(numbers).tolist()
    return samples, None if times is None else times[:end], every, tuple(notes)


def _part_numbers(
    table: RawTable, roles: TableRoles, stream: StreamColumns
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None, Sequence[int], tuple[str, ...]]:
    rows = table.rows if len(table.rows) else range(len(table))
    numbers = [column_numbers(table, i) for i in stream.places]
    marker = None if table.description is not None else _marker(numbers)
    if marker is not None:
        numbers = [np.where(values == marker, np.nan, values) for values in numbers]
    samples = np.stack([values * factor for values, factor in zip(numbers, stream.factors, strict=True)])
    times = None
    if roles.time is not None and roles.seconds is not None:
        times = column_numbers(table, roles.time)
    elif roles.time is not None:
        where = f"{table.path}: row {{}}, column {table.headings[roles.time]!r}"
        times = stamp_seconds(table.columns[roles.time].astype(object), where, rows)
    return samples, times, rows, () if marker is None else (f"{marker:g} taken for missing samples",)


def _check_alike(part: RawTable, roles: TableRoles) -> None:
    """Raise a `DataError` if a column that is left out for its values in the first rows may hold a signal later."""
    headings = headings_of(part.headings, part.units)
    for i, use in enumerate(roles.uses[: len(headings)]):
        left_out = use.role == IGNORED and use.reason in BY_VALUES
        if left_out and no_signal(headings[i], part.columns[i], part, i) is None:
            raise DataError(
                f"{part.path}: rows from {part.rows[0]} on, column {use.heading!r}",
                f"no longer {use.reason}, for which it would be left out",
                remedy=Remedy("choose the columns to read,", "axes", "NAME,NAME"),
            )


def _unnamed_axes(count: int, table: RawTable) -> tuple[str, ...]:
    """Return the axes of columns without headings; that of one alone may be at the end of the file's name."""
    named = heading(table.path.stem).axis if count == 1 else None
    return (named,) if named else default_axes(count)


def column_numbers(table: RawTable, place: int) -> NDArray[np.float64]:
    """Return a column as float64; a `DataError` names the cell that is no number."""
    column, rows = table.columns[place], table.rows if len(table.rows) else range(len(table))
    if column.dtype != object:
        return column.astype(np.float64)
    values = np.full(len(column), np.nan)
    for i, cell in enumerate(column):
        if cell is None:
            continue
        if is_number(cell):
            values[i] = float(cell)
        else:
            comma = isinstance(cell, str) and "," in cell
            columns = Remedy("choose the columns to read,", "axes", "NAME,NAME")
            raise DataError(
                f"{table.path}: row {rows[i]}, column {table.headings[place]!r}",
                f"expected a number, got {str(cell)!r}",
                remedy="write decimal points, not commas" if comma else columns,
            )
    return values


def _in_seconds(ticks: NDArray[np.float64], seconds: float) -> NDArray[np.float64]:
    """Return time stamps in s; ``ticks`` is overwritten."""
    values = _unwrapped(ticks)
    first = next((float(value) for value in values if np.isfinite(value)), 0.0)
    if LONG_AGO_S < abs(first * seconds) < MOST_SPAN**2:
        values -= first
    values *= seconds
    return values


def _unwrapped(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the ticks of a counter of 16 or 32 bits, continued where it starts again."""
    if steps_alike(values):
        return values
    back = np.flatnonzero(np.diff(values) < 0)
    if not len(back) or (values != np.round(values)).any():
        return values
    usual = float(np.median(np.diff(values)))
    for size in (2.0**16, 2.0**32):
        steps = np.diff(values)[back] + size
        if 0 <= values.min() <= values.max() < size and (steps > 0).all() and (steps <= 10 * usual).all():
            return values + size * np.concatenate([[0], np.cumsum(np.diff(values) < 0)])
    return values


def _trusted(
    times: NDArray[np.float64], table: RawTable, rate: float | None
) -> tuple[NDArray[np.float64] | None, str | None]:
    """Return the time stamps, or None if they are arrival times of blocks and a rate is given, and a note.

    Without a rate a `DataError` names the likely one.
    """
    if len(times) > 1 and times.min() == times.max():
        if rate is None and table.rate is None:
            raise DataError(
                table.path,
                f"time stands still: all {len(times)} stamps are the same",
                remedy=Remedy("give the rate instead, e.g.", "rate", 1000),
            )
        return None, "time stamps are all the same: not used"
    if steps_alike(times):
        return times, None
    if len(times) < 4 or not times[-1] > times[0] or times[-1] / 2 - times[0] / 2 > MOST_SPAN / 2:
        return times, None
    steps = np.diff(times)
    forward = steps[steps > 0]
    repeated = float(np.mean(steps == 0))
    holes = int(np.count_nonzero(steps > LONGEST_STEP * np.median(forward))) if len(forward) else 0
    if _are_rounded(steps):
        true = (len(times) - 1) / float(times[-1] - times[0])
        note = f"time stamps are rounded to {steps.min():.4g} s: taken as even, {true:.4g} Hz"
        return times[0] + np.arange(len(times)) / true, note
    early, late = _usual(steps), _usual(steps[::-1])
    if rate is None and early and late and not 0.8 * early < late < 1.25 * early:
        raise DataError(
            table.path,
            f"steps of {early:.4g} s between time stamps become {late:.4g} s",
            remedy=Remedy("give the rate to resample all to,", "rate", f"{1 / min(early, late):.4g}"),
        )
    if repeated <= MOST_REPEATED and holes <= max(3, MOST_HOLES * len(steps)):
        return times, None
    span = float(times[-1] - times[0])
    last = int(np.count_nonzero(times >= times[-1] - 1e-9)) if repeated > MOST_REPEATED else 1
    likely = (len(times) - last) / span if span > 0 else 0.0
    known = rate or table.rate
    if known is None:
        raise DataError(
            table.path,
            f"{round(repeated * len(steps))} of {len(times)} time stamps repeat the one before: they are "
            "too coarse or the arrival times of blocks"
            if repeated > MOST_REPEATED
            else "time stamps come in bursts, as of blocks",
            remedy=Remedy("give the rate instead,", "rate", f"{likely:.4g}"),
        )
    off = likely / known - 1 if known else 0.0
    far = f"; these say {likely:.4g} Hz: samples may be lost" if abs(off) > MOST_OFF else ""
    return None, f"time stamps are arrival times of blocks: not used, the rate is {known:g} Hz as given{far}"


def _are_rounded(steps: NDArray[np.float64]) -> bool:
    """Return whether some steps, at even distances, are twice as long as all others: 1 ms and 2 ms at 833 Hz."""
    ticks = np.rint(steps / steps.min()) if steps.min() > 0 else np.zeros(len(steps))
    apart = np.diff(np.flatnonzero(ticks == 2))
    if ticks.max() != 2 or len(apart) < 3 or not 1 < apart.min() <= apart.max() <= apart.min() + 1:
        return False
    return len(apart) > 0.02 * len(steps) and np.allclose(steps, ticks * steps.min(), rtol=1e-3)


def _usual(steps: NDArray[np.float64]) -> float | None:
    """Return the step that nearly all in the first quarter have."""
    first = steps[: max(1, len(steps) // 4)]
    usual = float(np.median(first))
    return usual if usual > 0 and len(first) > 3 and np.mean(np.abs(first / usual - 1) < 0.1) > 0.9 else None


def _on_grid(times: NDArray[np.float64], rate: float) -> bool:
    """Return whether time stamps are within half a sample of a rate that the file states."""
    grid = times[0] + np.arange(len(times)) / rate
    return bool(np.abs(times - grid).max() <= 0.5 / rate) if len(times) else False


def unit_note(
    stream: StreamColumns, uses: Sequence[ColumnUse], samples: NDArray[np.float32] | NDArray[np.float64]
) -> str | None:
    """Return a note on samples without a known unit, such as counts; that of accelerations may look like gravity.

    ``samples`` has shape (axis, time).
    """
    if stream.unit is not None or not samples.size:
        return None
    if spelled := {use.unit for use in uses if use.role in stream.axes and use.unit}:
        return f"unit {', '.join(sorted(spelled))} is not known: read as plain numbers, unit 1"
    if stream.name == "friction":
        return None
    mean = float(np.sqrt((np.nanmean(samples, axis=1) ** 2).sum())) if np.isfinite(samples).all() else np.nan
    scales = {"m/s^2": STANDARD_GRAVITY, "g": 1.0, "mg": 1000.0, "mm/s^2": 1e3 * STANDARD_GRAVITY}
    for unit, expected in scales.items():
        if len(samples) == 3 and abs(mean / expected - 1) < 0.15:
            gravity = Remedy(f"their mean of {mean:.3g} is that of gravity in {unit}:", "unit", unit)
            return Message("no unit stated: read as plain numbers", gravity)
    whole = bool((samples == np.round(samples)).all()) and float(np.abs(samples).max()) > 10
    if whole:
        scale = Remedy("say how many are one, e.g. of an MPU-6050 at ±2 g", "unit", "g/16384")
        return Message("no unit stated: read as counts", scale)
    return Message("no unit stated: read as plain numbers", Remedy("say it, e.g.", "unit", "g"))


def _marker(columns: Sequence[NDArray[np.float64]]) -> float | None:
    """Return the number that stands for missing samples, far beyond all others, as -9999."""
    for marker in MARKERS:
        masks = [values == marker for values in columns]
        if any(each.any() for each in masks):
            rest = max(
                float(np.nanmax(np.abs(v[~each]), initial=0.0))
                for v, each in zip(columns, masks, strict=True)
            )
            return marker if rest < abs(marker) / 10 else None
    return None


def _filled(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return time stamps with each missing one as the one before."""
    last = np.maximum.accumulate(np.where(np.isnan(times), 0, np.arange(len(times))))
    return times[last]
