"""Columns of a table, text or worksheet: time and samples, with units."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, UnitError
from tactogram.signal.io.content import FileContent
from tactogram.signal.io.description import SignalDescription
from tactogram.signal.io.labels import label_columns, spare_columns
from tactogram.signal.io.layout import IGNORED, TIME, ColumnUse, TableLayout, layout_for
from tactogram.signal.io.stamps import stamp_columns
from tactogram.signal.units import parse_seconds, parse_unit, split_heading

TIME_NAMES = frozenset(
    [
        "t",
        "time",
        "timestamp",
        "timestamps",
        "time stamp",
        "sample time",
        "relative time",
        "elapsed",
        "elapsed time",
        "time elapsed",
        "seconds",
        "seconds elapsed",
        "elapsed seconds",
        "zeit",
        "date",
        "datetime",
        "date time",
        "epoch",
        "epoc",  # MetaMotion
        "millis",  # Arduino, as below
        "micros",
        "ms",
        "us",
    ]
)
"""Headings of a column of time stamps, in any case, with ``_s``, ``_ms``, ``_us`` or ``[s]`` … for the unit."""
_AXIS = re.compile(r"(?:.*[^a-z])?(?:a|acc|accel|gf)?([xyz])(?:[^a-z]*(?:axis|achse|value))?")
"""Name of an axis in a heading: ``Acceleration x``, ``X-Axis``, ``acc_y``, ``az``."""
_MAGNITUDE = re.compile(r"(?:absolute|abs|total|resultant)\b.*|.*\b(?:magnitude|norm|abs)|at|tgf|atotal")
"""Columns computed from three axes: ``Absolute acceleration`` (phyphox), ``aT`` and ``TgF`` (Physics Toolbox)."""
DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
MOST_MISSING = 3
"""Rows without a sample, one after the other, that are left to the resampling between time stamps (`to_uniform`)."""
SLOWEST = 0.1
"""Step above which a time column needs a unit, since it is likely in ms."""


@dataclass(frozen=True)
class TableColumns:
    """Time and sample columns of a table."""

    names: tuple[str, ...]  # of the sample columns
    places: tuple[int, ...]  # their indices
    unit: str | None  # one of `UNITS`, if headings or layout name it
    factors: tuple[float, ...]  # which convert each column to it
    time: int | None  # index of the time stamps
    seconds: float | None  # their unit in s, if heading or layout names it
    stamped: bool  # whether the time stamps place the samples, some of which may then be missing
    dated: bool  # whether the time stamps are dates or times of day rather than numbers
    uses: tuple[ColumnUse, ...]  # of every column
    layout: TableLayout | None = None  # which decided
    labels: Mapping[str, int] = field(default_factory=dict)  # indices of the columns of labels by role

    @property
    def used(self) -> tuple[int, ...]:
        """Indices of the samples, then of the time stamps."""
        return self.places if self.time is None else (*self.places, self.time)


def choose(
    headings: Sequence[str],
    path: Path,
    description: SignalDescription | None,
    *,
    columns: Sequence[str] | None = None,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
    rows: Sequence[Sequence[object]] = (),
    labelled: bool = False,
) -> TableColumns:
    """Return the columns to read of a table with these headings and first rows.

    They are those named by ``columns``; else by the one of ``layouts`` with these headings; else by ``axes``, if they
    are headings; else all but the time and those without numbers. A missing or repeated one, or different units, are a
    `DataError`. Columns of labels are found if ``labelled``; otherwise they are as any other.
    """
    text, stamps = text_columns(rows), stamp_columns(rows)
    split = [split_heading(heading) for heading in headings]
    names = [name for name, _ in split]
    layout = None if description is not None or columns is not None else layout_for(headings, layouts)
    labels: dict[str, int] = {}
    if labelled and description is None and columns is None:
        labels = _labels(headings, rows, text, layout)
    spare = spare_columns(headings, rows, text) if labels else ()
    without = text.union(labels.values(), spare)
    if layout is not None and layout.axes:
        at = None if layout.time is None else headings.index(layout.time)
        places, chosen = [headings.index(heading) for heading in layout.axes.values()], tuple(layout.axes)
    else:
        at = time_column(headings, path, time if layout is None else layout.time, text)
        if at is None and (layout is None or layout.time is None):
            at = min(stamps, default=None)
        if columns is None and axes is not None and all(name in names for name in axes):
            columns = axes
        if columns is None:
            places = _samples(names, at, without, described=description is not None)
        else:
            places = [_find(headings, names, name, path) for name in columns]
        chosen = tuple(names[i] for i in places)
        if columns is None and description is None:
            chosen = axis_names(chosen) or chosen
    if not places:
        raise DataError(f"{path}: no column of samples besides the time, got {', '.join(headings)}")
    if len(set(chosen)) < len(chosen):
        raise DataError(f"{path}: columns must have different names, got {', '.join(chosen)}")
    if description is not None and columns is None and chosen != description.axes:
        raise DataError(
            f"{path}: described with axes {', '.join(description.axes)}, its columns are {', '.join(chosen)}; "
            "remove the description"
        )
    spelled = [split[i][1] if layout is None or layout.unit is None else layout.unit for i in places]
    units = [_unit(one) for one in spelled]
    if len({unit for unit, _ in units}) > 1:
        listed = ", ".join(headings[i] for i in places)
        alike = [names[i] for i, unit in zip(places, units, strict=True) if unit[0] == units[0][0]]
        typed = not any(re.search(r"[\s,;`]", name) for name in alike)
        remedy = (
            f"choose those of one, e.g. `axes={','.join(alike)}`" if typed else "choose those of one as axes"
        )
        raise DataError(f"{path}: columns are in different units: {listed}; {remedy}")
    time_unit = stamps.get(-1 if at is None else at) or (layout and layout.time_unit)
    dated = at in stamps
    uses = {
        i: ColumnUse(headings[i], name, unit) for i, name, unit in zip(places, chosen, spelled, strict=True)
    }
    uses |= {i: ColumnUse(headings[i], role) for role, i in labels.items()}
    if at is not None:
        uses[at] = ColumnUse(headings[at], TIME, time_unit or time_unit_of(headings[at]))
    return TableColumns(
        names=chosen,
        places=tuple(places),
        unit=units[0][0],
        factors=tuple(factor for _, factor in units),
        time=at,
        seconds=1.0 if dated else None if at is None else parse_seconds(uses[at].unit or ""),
        stamped=at is not None and description is None,
        dated=dated,
        uses=tuple(uses.get(i, ColumnUse(heading, IGNORED)) for i, heading in enumerate(headings)),
        layout=layout,
        labels=labels,
    )


def is_number(cell: object) -> bool:
    """Return whether a cell holds a number, as text or as a value of a worksheet."""
    if not isinstance(cell, str):
        return isinstance(cell, int | float) and not isinstance(cell, bool)
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def text_columns(rows: Sequence[Sequence[object]]) -> frozenset[int]:
    """Return the columns without a number in the first rows; none if no column has any."""
    width = min((len(row) for row in rows), default=0)
    text = [i for i in range(width) if not any(is_number(row[i]) or _comma(row[i]) for row in rows)]
    return frozenset(text if len(text) < width else ())


def _comma(cell: object) -> bool:
    return isinstance(cell, str) and DECIMAL_COMMA.fullmatch(cell) is not None


def table_content(
    numbers: NDArray[np.float64],
    chosen: TableColumns,
    rows: Sequence[int],
    headings: Sequence[str],
    description: SignalDescription | None,
    path: Path,
    *,
    named: bool,
    labels: Mapping[str, Sequence[str]] | None = None,
) -> FileContent:
    """Return the content of a table from ``numbers`` (row, used column) and the numbers of its rows in the file.

    With ``labels`` of the rows, gaps are left to the cut by them.
    """
    labels = labels or {}
    if chosen.stamped:
        kept = _without_gaps(numbers, rows, path, longest=None if labels else MOST_MISSING)
        numbers, rows = numbers[kept], [rows[i] for i in kept]
        labels = {role: [values[i] for i in kept] for role, values in labels.items()}
    samples, times = numbers[:, : len(chosen.places)].T, None
    if any(factor != 1 for factor in chosen.factors):
        samples = samples * np.array(chosen.factors)[:, None]
    if chosen.stamped:
        times = numbers[:, -1]
        if chosen.seconds is None and len(times) > 1 and abs(float(np.median(np.diff(times)))) > SLOWEST:
            raise DataError(
                f"{path}: time column without unit goes in steps of {np.median(np.diff(times)):g}: "
                "head it 'time [s]', 'time [ms]' or 'time [us]'"
            )
        times = times * (chosen.seconds or 1.0)

    def place(axis: int, sample: int) -> str:
        column = chosen.time if axis < 0 else chosen.places[axis]
        return f"row {rows[sample]}, column {headings[column or 0]!r}"

    return FileContent(
        samples=samples,
        axes=chosen.names if named else (),
        rate=description.rate if description else None,
        times=times,
        unit=description.unit if description else chosen.unit,
        description=description,
        place=place,
        uses=chosen.uses,
        layout=chosen.layout,
        labels=labels,
        rows=rows,
    )


def _without_gaps(
    numbers: NDArray[np.float64], rows: Sequence[int], path: Path, *, longest: int | None
) -> NDArray[np.int64]:
    """Return the rows that have all samples; a `DataError` if more than ``longest`` in a row have not."""
    missing = np.isnan(numbers[:, :-1]).any(axis=1)
    places = np.flatnonzero(missing)
    for gap in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1):
        if longest is not None and len(gap) > longest:
            raise DataError(
                f"{path}: rows {rows[gap[0]]} to {rows[gap[-1]]} lack a number; at most {longest} in a row are "
                "interpolated, cut the recording there"
            )
    return np.flatnonzero(~missing)


def time_column(
    headings: Sequence[str], path: Path, time: str | None = None, text: Collection[int] = ()
) -> int | None:
    """Return the place of the time stamps: the column ``time``, else the one headed as such, if there is one."""
    names = [split_heading(heading)[0] for heading in headings]
    if time is not None:
        return _find(headings, names, time, path)
    found = {_plain(name): i for i, name in reversed([*enumerate(names)]) if i not in text}
    found = {name: i for name, i in found.items() if name in TIME_NAMES}
    # Sensor Logger writes both: nanoseconds since 1970 as ``time``, and seconds.
    return found.get("seconds elapsed", min(found.values(), default=None))


def time_unit_of(heading: str) -> str | None:
    """Return the unit of time that a heading names: ``Time (ms)``, ``t_us``, ``seconds elapsed``."""
    name, unit = split_heading(heading)
    if unit is not None:
        return unit
    if "seconds" in _plain(name).split():
        return "s"
    if (plain := _plain(name)) in ("millis", "micros", "ms", "us"):
        return {"millis": "ms", "micros": "us"}.get(plain, plain)
    ending = name.lower().rpartition("_")[2] if "_" in name else ""
    return ending if parse_seconds(ending) else None


def _find(headings: Sequence[str], names: Sequence[str], name: str, path: Path) -> int:
    for candidates in (headings, names):
        if name in candidates:
            return candidates.index(name)
    raise DataError(f"{path}: no column {name!r}, there are {', '.join(headings)}")


def axis_names(names: Sequence[str]) -> tuple[str, ...] | None:
    """Return x, y and z as far as each name names another of them; None if any does not."""
    found = [_AXIS.fullmatch(name.lower()) for name in names]
    letters = tuple(match[1] for match in found if match)
    return letters if len(letters) == len(set(letters)) == len(names) else None


def _labels(
    headings: Sequence[str],
    rows: Sequence[Sequence[object]],
    text: frozenset[int],
    layout: TableLayout | None,
) -> dict[str, int]:
    """Return the columns of labels by role: those of the layout; without axes in it, those of the headings, too."""
    stated = {} if layout is None else {role: headings.index(name) for role, name in layout.labels.items()}
    found = {} if layout is not None and layout.axes else label_columns(headings, rows, text)
    return {role: i for role, i in found.items() if i not in stated.values()} | stated


def _samples(names: Sequence[str], time: int | None, text: Collection[int], *, described: bool) -> list[int]:
    """Return the indices of the samples: all but time stamps, texts, and the magnitude of three axes."""
    if described:
        return [i for i in range(len(names)) if i != time]
    places = [i for i in range(len(names)) if i != time and i not in text]
    if time is None:
        return places
    places = [i for i in places if _plain(names[i]) not in TIME_NAMES]
    axes = [i for i in places if not _MAGNITUDE.fullmatch(names[i].lower())]
    return axes if len(axes) == 3 and axis_names([names[i] for i in axes]) else places


def _plain(name: str) -> str:
    """Return a heading in lower case without the unit at its end, its words divided by blanks."""
    words = re.sub(r"[\s_-]+", " ", name.lower()).strip()
    return re.sub(r" (s|ms|us|ns)$", "", words)


def _unit(text: str | None) -> tuple[str | None, float]:
    if text is None:
        return None, 1.0
    try:
        return parse_unit(text)
    except UnitError:
        return None, 1.0
