"""Tables in long form: rows of several sensors or axes, one after the other, told apart by a column of their names."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tactogram.signal.io.clocks import clocks_of
from tactogram.signal.io.content import RawTable
from tactogram.signal.io.labels import HEADINGS, label_of_cell
from tactogram.signal.io.stamps import is_stamp
from tactogram.signal.io.table_head import is_number
from tactogram.signal.io.vocabulary import heading, headings_of, words_of

MOST_SENSORS = 16
MOSTLY = 0.1
"""Share of rows at which the name changes, of columns that are not called after sensors."""
SENSORS = (
    "sensor",
    "sensors",
    "device",
    "node",
    "imu",
    "mac",
    "hand",
    "side",
    "finger",
    "axis",
    "channel",
    "field",
    "source",
)
"""Words of the heading of such a column."""
_SWITCHES = frozenset(["true", "false", "yes", "no", "on", "off", "ok", "am", "pm"])


def split_by_sensor(table: RawTable) -> list[RawTable]:
    """Return a table in long form as one of each sensor, or as one with a column of each axis if all are sampled alike.

    The names of the sensors stand before the headings; any other table is returned as it is.
    """
    key = next((i for i in range(len(table.headings)) if _tells_apart(table, i)), None)
    if table.description is not None or key is None:
        return [table]
    names = np.array([label_of_cell(cell) for cell in table.columns[key]])
    parts = [_part(table, key, name, np.flatnonzero(names == name)) for name in dict.fromkeys(names)]
    first = parts[0]
    alike = bool(first.columns) and all(
        len(part.columns) == len(first.columns) and np.array_equal(part.columns[0], first.columns[0])
        for part in parts
    )
    if alike and len(first.columns) == 2 and len(parts) > 1:  # one clock and one value
        return [
            replace(
                first,
                headings=(first.headings[0], *(part.headings[1] for part in parts)),
                columns=(first.columns[0], *(part.columns[1] for part in parts)),
                units=(first.units[0], *(part.units[1] for part in parts)) if first.units else (),
            )
        ]
    return parts


def _tells_apart(table: RawTable, index: int) -> bool:
    """Return whether a column holds the names or numbers of a few sensors, by turns."""
    column, words = table.columns[index], words_of(table.headings[index])
    usual = any(word in names for word in words for names in HEADINGS.values())
    if usual or heading(table.headings[index]).quantity or len(column) < 4:  # DeviceOrientation: faceUp
        return False
    called = any(word in SENSORS for word in words)
    if column.dtype != object:
        numbered = any(word.isdigit() for word in words)
        if not called or numbered or not np.isfinite(column).all() or (column != np.round(column)).any():
            return False
    elif not all(isinstance(cell, str) and not is_number(cell) and not is_stamp(cell) for cell in column):
        return False
    names = [label_of_cell(cell) for cell in column]
    distinct = set(names)
    if (
        not 1 < len(distinct) <= min(MOST_SENSORS, len(names) // 2)
        or {name.lower() for name in distinct} <= _SWITCHES
    ):
        return False
    return called or float(np.mean([a != b for a, b in itertools.pairwise(names)])) > MOSTLY


def _part(table: RawTable, key: int, name: str, rows: NDArray[np.int64]) -> RawTable:
    """Return the rows of one sensor, without the columns that are empty there; the clock comes first."""
    columns = [column[rows] for column in table.columns]
    headings = headings_of(table.headings, table.units)
    clocks = clocks_of(replace(table, columns=tuple(columns), rows=()), headings)
    kept = [
        i
        for i, column in enumerate(columns)
        if i != key and i not in clocks and column.dtype != object and np.isfinite(column).any()
    ]
    name = name if table.columns[key].dtype == object else f"{table.headings[key]} {name}"
    letters: Sequence[str] = "xyz" if len(kept) == 3 else [table.headings[i] for i in kept]
    ends = [table.headings[i] for i in kept] if table.named else letters
    order = [*clocks, *kept]
    return replace(
        table,
        headings=(
            *(table.headings[i] if table.named else f"time {number}" for number, i in enumerate(clocks, 1)),
            *(f"{name} {end}" for end in ends),
        ),
        columns=tuple(columns[i] for i in order),
        units=tuple(table.units[i] for i in order) if table.units else (),
        groups=(),
        named=True,
        rows=[table.rows[i] for i in rows] if len(table.rows) else rows.tolist(),
        notes=(*table.notes, f"rows apart by {table.headings[key]!r}"),
    )
