"""Roles of columns: which are time stamps, counters, labels and axes of a quantity, by heading, unit and values.

One quantity becomes the signal, others with units become further streams, and the rest is named with the reason.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, Remedy
from tactogram.signal.io.clocks import choose_clock, clocks_of, ticks_evenly
from tactogram.signal.io.content import IGNORED, RATE, TIME, ColumnUse, RawTable, TableLayout, default_axes
from tactogram.signal.io.labels import label_columns
from tactogram.signal.io.stamps import is_date
from tactogram.signal.io.table_head import is_number
from tactogram.signal.io.vocabulary import STREAM_OF_UNIT, Heading, heading, headings_of
from tactogram.signal.units import split_heading

MAIN = (
    *("acceleration", "linear_acceleration", "force", "friction", "velocity", "position", "sound", "voltage"),
    *("", "angular_rate", "pressure", "gravity", "magnetic_field", "orientation"),
)
"""Streams in the order in which they are taken for the signal; the empty one has no known quantity."""


MOST_UNNAMED = 3
"""Columns without headings that are taken for axes of one signal."""


@dataclass(frozen=True)
class StreamColumns:
    """Columns of one stream."""

    name: str  # of the stream
    places: tuple[int, ...]
    axes: tuple[str, ...]
    unit: str | None  # one of `UNITS`, if headings, layout or name state it
    factors: tuple[float, ...]  # which convert each column to it
    layout: TableLayout | None = None  # which decided
    chosen: bool = False  # by the names of the columns


@dataclass(frozen=True)
class TableRoles:
    """Roles of the columns of a table."""

    streams: tuple[StreamColumns, ...]  # that of the signal first
    time: int | None
    seconds: float | None  # unit of numeric time stamps, s; None of calendar stamps
    uses: tuple[ColumnUse, ...]
    labels: Mapping[str, int] = field(default_factory=dict)  # columns of labels by role
    notes: tuple[str, ...] = ()


def roles_of(
    table: RawTable,
    *,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    rate: float | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> TableRoles:
    """Return what the columns hold; a `DataError` that says what to choose where two readings are plausible.

    The one of ``layouts`` with these headings decides; else ``axes`` that are headings choose the columns of the
    signal; else headings, units and values decide. ``time`` names the time stamps (``none`` for none), with their
    unit if need be: ``ticks [us]``. Columns of labels are found if ``labelled``.
    """
    headings = headings_of(table.headings, table.units)
    alike = layouts_of(table, layouts) if table.description is None else []
    by_layout = [layout for layout in alike if layout.axes]
    clocks = clocks_of(table, headings)
    stated = alike[0] if alike else None
    if stated is not None and (stated.axes or stated.time):
        time = stated.time and f"{stated.time} [{stated.time_unit}]" if stated.time_unit else stated.time
        time = time or "none"
    clock = choose_clock(table, headings, clocks, time=time, rate=rate)
    at = None if clock is None else clock.place
    labels: dict[str, int] = {}
    if labelled and table.description is None:
        named = {} if by_layout else label_columns(table, at)
        own = (
            {}
            if stated is None
            else {role: table.headings.index(text) for role, text in stated.labels.items()}
        )
        labels = {role: i for role, i in named.items() if i not in own.values()} | own
    others = {i: "clock" for i in clocks if i != at} | dict.fromkeys(labels.values(), "label")
    notes = [] if clock is None or clock.note is None else [clock.note]
    if by_layout:
        streams = tuple(_of_layout(layout, table, headings) for layout in by_layout)
        reasons = {i: no_signal(headings[i], table.columns[i], table, i) for i in range(len(headings))}
        others = {i: what for i, what in reasons.items() if what} | others
    elif table.description is not None:
        streams = (_described(table, at),)
    else:
        known = [
            name for name in axes or () if name in table.groups or _place(name, table, headings) is not None
        ]
        streams = (_chosen(axes, table, headings),) if axes and known else _found(table, headings, at, others)
    uses = _uses(table, headings, streams, at, clock.unit if clock else None, others, labels)
    if not by_layout and table.description is None:
        notes += _left_out(uses, headings)
    return TableRoles(streams, at, clock.seconds if clock else None, uses, labels, tuple(notes))


def layouts_of(table: RawTable, layouts: Sequence[TableLayout]) -> list[TableLayout]:
    """Return the layouts of tables with these headings; labels that one of them states hold for all."""
    alike = [
        each for each in layouts if tuple(c for c in each.columns if c != table.rate_name) == table.headings
    ]
    labels = {role: name for layout in alike for role, name in layout.labels.items()}
    return [layout.model_copy(update=labels) for layout in alike]


def rank_of(stream: str) -> int:
    """Return the place of a stream in the order in which they are taken for the signal."""
    return MAIN.index(stream) if stream in MAIN else len(MAIN)


def axis_letters(headings: Sequence[Heading]) -> tuple[str, ...] | None:
    """Return x, y and z as far as each heading names another of them; None if any does not."""
    letters = tuple(each.axis for each in headings if each.axis)
    return letters if len(set(letters)) == len(letters) == len(headings) else None


def _of_layout(layout: TableLayout, table: RawTable, headings: Sequence[Heading]) -> StreamColumns:
    places = [table.headings.index(text) for text in layout.axes.values()]
    parts = [replace(headings[i], unit=layout.unit) if layout.unit else headings[i] for i in places]
    stream = _converted(layout.stream or "", places, [*layout.axes], parts, table)
    return replace(stream, layout=layout)


def _described(table: RawTable, time_index: int | None) -> StreamColumns:
    """Return the columns of a table that this package wrote."""
    description = table.description
    assert description is not None  # noqa: S101
    places = [i for i in range(len(table.headings)) if i != time_index]
    names = tuple(split_heading(table.headings[i])[0] for i in places)
    if names != description.axes:
        raise DataError(
            f"described with axes {', '.join(description.axes)}, its columns are {', '.join(names)}; "
            "remove the description"
        )
    return StreamColumns("", tuple(places), names, description.unit, (1.0,) * len(places))


def _chosen(names: Sequence[str], table: RawTable, headings: Sequence[Heading]) -> StreamColumns:
    places = []
    for name in names:
        if name in table.groups and name not in table.headings:
            places += [i for i, group in enumerate(table.groups) if group == name]
            continue
        index = _place(name, table, headings)
        if index is None:
            raise DataError(f"no column {name!r}, there are {', '.join(table.headings)}")
        places.append(index)
    if len(set(places)) < len(places):
        raise DataError(f"columns must be different, got {', '.join(names)}")
    parts = [headings[i] for i in places]
    whole = len(names) == 1 < len(places)  # a matrix
    names = axis_letters(parts) or (default_axes(len(places)) if whole else _names(places, table, headings))
    if len(set(names)) < len(names):
        names = [str(i + 1) for i in places]
    return replace(_converted(_stream_of(parts), places, names, parts, table), chosen=True)


def _place(name: str, table: RawTable, headings: Sequence[Heading]) -> int | None:
    for candidates in (table.headings, [each.name for each in headings]):
        if name in candidates:
            return candidates.index(name)
    if name.isdigit() and 1 <= int(name) <= len(headings):
        return int(name) - 1
    letters = [i for i, each in enumerate(headings) if each.axis == name]
    return letters[0] if len(letters) == 1 else None


def _found(
    table: RawTable, headings: Sequence[Heading], time_index: int | None, others: dict[int, str]
) -> tuple[StreamColumns, ...]:
    """Return the streams in a table, that of the signal first; ``others`` gets what the other columns are."""
    for i, (each, column) in enumerate(zip(headings, table.columns, strict=True)):
        if i != time_index and i not in others and (what := no_signal(each, column, table, i)):
            others[i] = what
    places = [i for i in range(len(headings)) if i != time_index and i not in others]
    for spare in ("magnitude", "in {unit}"):
        if not places:
            places = [i for i, what in others.items() if what == spare.format(unit=headings[i].unit)]
            for i in places:
                del others[i]
    if not table.named and not table.groups and len(places) > MOST_UNNAMED:
        listed = ",".join(table.headings[i] for i in places[:3])
        raise DataError(
            f"{len(places)} columns of numbers without headings ({table.headings[places[0]]} to "
            f"{table.headings[places[-1]]}): which are axes of one signal?",
            remedy=Remedy("choose, e.g.", "axes", listed),
        )
    if not places:
        raise DataError(
            f"no column of samples besides the time, got {', '.join(table.headings)}",
            remedy=Remedy(
                "choose them:",
                "axes",
                ",".join([name for i, name in enumerate(table.headings) if i != time_index][:3]),
            ),
        )
    groups: dict[str, list[int]] = {}
    for i in places:
        groups.setdefault(_stream_of([headings[i]]), []).append(i)
    if "acceleration" not in groups and "linear_acceleration" in groups:
        groups = {
            "acceleration" if name == "linear_acceleration" else name: each for name, each in groups.items()
        }
    if "" in groups and len(groups) == 1 and (named := heading(table.path.stem).quantity):
        groups = {named: groups[""]}
    units = {name: headings[each[0]].converted()[0] for name, each in groups.items()}
    lettered = {name: any(headings[i].axis for i in each) for name, each in groups.items()}

    def rank(name: str) -> tuple[bool, int]:
        later = (
            units[name] is None
            and name not in ("acceleration", "linear_acceleration")
            and not (name == "" and lettered[name])
        )
        return later, rank_of(name)

    first = min(groups, key=rank)
    streams = [_axes_of(first, groups[first], table, headings, others)]
    for name in sorted(groups, key=rank):
        if name == first:
            continue
        if units[name] in (None, "1") and name != "friction":
            others |= dict.fromkeys(
                groups[name], f"{name.replace('_', ' ')} without unit" if name else "no unit"
            )
        elif name in ("torque",):
            others |= dict.fromkeys(groups[name], "torque")
        else:
            streams.append(_axes_of(name, groups[name], table, headings, others, ask=False))
    return tuple(streams)


def no_signal(each: Heading, column: NDArray[np.generic], table: RawTable, place: int) -> str | None:
    """Return what a column is that is no signal; None if it may be one."""
    if column.dtype == object:
        numbers = sum(is_number(cell) for cell in column[:200] if cell is not None)
        if all(is_date(cell) for cell in column[:200] if cell is not None):
            return "date"
        mixed = 2 * numbers >= sum(cell is not None for cell in column[:200])
        return None if mixed and not each.other else "text"
    values = column[np.isfinite(column)]
    if not len(values):
        return "empty"
    steps = np.diff(values)
    whole = bool(np.all(values == np.round(values)))
    counts = whole and len(steps) > 0 and float(np.mean(steps == 1)) > 0.9
    plain = place == 0 and each.quantity is None and len(table.columns) > 2
    if counts and len(table.columns) > 1 and (each.is_counter or not table.named or plain):
        return "counter"
    rising = whole and len(steps) > 0 and bool((steps >= 0).all()) and values[-1] > values[0]
    rising = rising and (not table.brief or ticks_evenly(values))
    if each.is_counter and each.name and rising and len(table.columns) > 1:
        return "counter"
    if (
        len(values) > 20
        and not table.brief
        and np.isin(values, (0, 1)).all()
        and len(table.columns) > 2
        and not (each.axis or each.unit)
    ):
        return "0 and 1 alone"
    constant = len(values) > 1 and bool((steps == 0).all()) and not table.brief
    if (
        constant
        and (not table.named or (each.axis is None and each.quantity is None))
        and len(table.columns) > 1
    ):
        return "constant"
    if each.other is not None:
        return each.other
    if each.unit is not None and each.converted()[0] is None and each.quantity is None and not each.axis:
        return f"in {each.unit}"
    return None


def _axes_of(
    name: str,
    places: Sequence[int],
    table: RawTable,
    headings: Sequence[Heading],
    others: dict[int, str],
    *,
    ask: bool = True,
) -> StreamColumns:
    """Return the axes of a stream: those of the only sensor with axes, else all of its columns under their names."""
    sensors: dict[str, list[int]] = {}
    for i in places:
        if headings[i].axis:
            sensors.setdefault(headings[i].sensor, []).append(i)
    stated = {name: each for name, each in sensors.items() if headings[each[0]].unit is not None}
    if len(sensors) > 1 and len(stated) == 1:
        others |= {
            i: "without unit, beside those with one"
            for name, each in sensors.items()
            if name not in stated
            for i in each
        }
        sensors = stated
        places = [i for i in places if i not in others]
    if (
        len(sensors) > 1
        and ask
        and axis_letters([headings[i] for each in sensors.values() for i in each]) is None
    ):
        listed = " or ".join(", ".join(table.headings[i] for i in each) for each in [*sensors.values()][:4])
        first = ",".join(headings[i].name for i in next(iter(sensors.values())))
        raise DataError(
            f"which {name.replace('_', ' ') or 'columns'}: {listed}?",
            remedy=Remedy("choose, e.g.", "axes", first),
        )
    if sensors:
        lettered = sorted(
            (i for each in sensors.values() for i in each), key=lambda i: headings[i].axis or ""
        )
        letters = axis_letters([headings[i] for i in lettered])
        others |= {i: "beside the axes" for i in places if i not in lettered}
        names = [*letters] if letters else _names(lettered, table, headings)
        return _converted(name, lettered, names, [headings[i] for i in lettered], table)
    matrix = [bool(table.groups) and table.headings[i] != table.groups[i] for i in places]
    numbered = all(matrix)
    arrays = dict.fromkeys(table.groups[i] for i in places) if table.groups else {}
    if len(arrays) > 1 and (any(matrix) or (ask and name == "")):
        raise DataError(
            "which array?", remedy=Remedy(f"choose of {', '.join(arrays)}, e.g.", "axes", next(iter(arrays)))
        )
    plain = numbered or (not table.named and len(places) in (1, 3))
    names = [*default_axes(len(places))] if plain else _names(places, table, headings)
    return _converted(name, places, names, [headings[i] for i in places], table)


def _names(places: Sequence[int], table: RawTable, headings: Sequence[Heading]) -> list[str]:
    names = [headings[i].name or table.headings[i] for i in places]
    return names if len(set(names)) == len(names) else [table.headings[i] for i in places]


def _converted(
    name: str, places: Sequence[int], axes: Sequence[str], parts: Sequence[Heading], table: RawTable
) -> StreamColumns:
    units = [part.converted() for part in parts]
    known = {unit for unit, _ in units if unit is not None}
    if len(known) > 1:
        listed = ", ".join(part.text for part in parts)
        raise DataError(
            f"columns are in different units: {listed}",
            remedy=Remedy("choose those of one,", "axes", "NAME,NAME"),
        )
    if len(set(axes)) < len(axes):
        numbers = ",".join(str(i + 1) for i in places)
        raise DataError(
            f"columns must have different names, got {', '.join(axes)}",
            remedy=Remedy("choose by number,", "axes", numbers),
        )
    return StreamColumns(
        name, tuple(places), tuple(axes), known.pop() if known else None, tuple(factor for _, factor in units)
    )


def _stream_of(parts: Sequence[Heading]) -> str:
    quantities = {part.quantity for part in parts}
    if len(quantities) == 1 and (quantity := quantities.pop()):
        return quantity
    units = {part.converted()[0] for part in parts}
    unit = units.pop() if len(units) == 1 else None
    return STREAM_OF_UNIT[unit] if unit not in (None, "1") else ""


def _uses(
    table: RawTable,
    headings: Sequence[Heading],
    streams: Sequence[StreamColumns],
    time_index: int | None,
    time_unit: str | None,
    others: Mapping[int, str],
    labels: Mapping[str, int],
) -> tuple[ColumnUse, ...]:
    uses = [
        ColumnUse(text, IGNORED, each.unit, reason=others.get(i))
        for i, (text, each) in enumerate(zip(table.headings, headings, strict=True))
    ]
    for role, i in labels.items():
        uses[i] = ColumnUse(table.headings[i], role)
    for number, stream in enumerate(streams):
        for i, axis in zip(stream.places, stream.axes, strict=True):
            unit = stream.layout.unit if stream.layout and stream.layout.unit else headings[i].unit
            uses[i] = ColumnUse(table.headings[i], axis, unit, stream=stream.name if number else None)
    if time_index is not None:
        uses[time_index] = ColumnUse(table.headings[time_index], TIME, time_unit)
    if table.groups and table.rate_name is not None:
        uses.append(ColumnUse(table.rate_name, RATE))
    return tuple(uses)


def _left_out(uses: Sequence[ColumnUse], headings: Sequence[Heading]) -> list[str]:
    """Return a line that names the columns without a role, if there are any."""
    texts = [
        f"{use.heading or 'a column without heading'} ({use.reason})" if use.reason else use.heading
        for use in uses
        if use.role == IGNORED
    ]
    return [f"left out: {', '.join(texts)}"] if texts else []
