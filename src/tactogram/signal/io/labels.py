"""Columns of words or codes in a table: material, session, subject and trial of each row, and its cut by them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tactogram.signal.io.content import MATERIAL, SESSION, SUBJECT, TRIAL, Column, FileContent, RawTable
from tactogram.signal.units import split_heading

HEADINGS = {
    MATERIAL: ("material", "surface", "texture", "label", "class", "activity", "target_name"),
    SESSION: ("session",),
    SUBJECT: ("subject", "participant"),
    TRIAL: ("trial", "take"),
}
"""Their usual headings, in any case; of several in a table, the first one counts."""
LONGEST_STEP = 4.5
"""Step between time stamps, in typical ones, above which more samples are missing than are interpolated."""
_WHOLE = re.compile(r"[-+]?\d+(\.0*)?")


def label_columns(table: RawTable, time: int | None) -> dict[str, int]:
    """Return the columns of labels by role, as headings and cells suggest; none without one of materials.

    They hold words or whole numbers.
    """
    names = [split_heading(heading)[0].lower() for heading in table.headings]
    columns: dict[str, int] = {}
    for role, usual in HEADINGS.items():
        places = [names.index(name) for name in usual if name in names]
        for index in places:
            if index != time and _codes(table.columns[index]):
                columns.setdefault(role, index)
    return columns if MATERIAL in columns else {}


def label_of_cell(cell: object) -> str:
    """Return the label in a cell, empty if there is none; codes of floating point (``3.0``) are whole numbers."""
    text = "" if cell is None or cell != cell else str(cell).strip()
    return text.partition(".")[0] if _WHOLE.fullmatch(text) else text


def _codes(column: Column) -> bool:
    if column.dtype == object:
        return True
    values = column[np.isfinite(column)].astype(np.float64)
    return bool((values == np.round(values)).all())


@dataclass(frozen=True, eq=False)
class Interval:
    """Rows of a table with the same labels, without a gap between them."""

    labels: Mapping[str, str]  # by role; without empty ones
    rows: tuple[int, int]  # numbers of the first and the last one in the file
    contents: tuple[FileContent, ...]


def cut(contents: Sequence[FileContent]) -> list[Interval]:
    """Return the intervals of a table in order; ``contents`` are its streams, each with the labels.

    A cut is wherever a label changes, time goes back, or a gap in any of the streams is too long to interpolate.
    """
    starts = np.unique(np.concatenate([np.array(each.rows)[_starts(each)] for each in contents]))
    first = contents[0]
    places = [np.searchsorted(each.rows, starts) for each in contents]
    intervals = []
    for number, begin in enumerate(places[0]):
        ends = [
            p[number + 1] if number + 1 < len(p) else len(c.rows)
            for p, c in zip(places, contents, strict=True)
        ]
        if begin == ends[0]:
            continue
        parts = [_part(c, p[number], end) for c, p, end in zip(contents, places, ends, strict=True)]
        labels = {role: values[begin] for role, values in first.labels.items() if values[begin]}
        intervals.append(Interval(labels, (first.rows[begin], first.rows[ends[0] - 1]), tuple(parts)))
    return intervals


def _starts(content: FileContent) -> NDArray[np.bool_]:
    """Return whether an interval begins at each row."""
    begins = np.zeros(len(content.rows), dtype=bool)
    begins[:1] = True
    for values in content.labels.values():
        begins[1:] |= np.array(values[1:]) != np.array(values[:-1])
    if content.times is not None and len(content.times) > 1:
        with np.errstate(over="ignore"):
            steps = np.diff(content.times)
            forward = steps[steps > 0]
            begins[1:] |= steps < 0
            if len(forward):
                begins[1:] |= steps > LONGEST_STEP * np.median(forward)
    return begins


def _part(content: FileContent, begin: int, end: int) -> FileContent:
    return replace(
        content,
        samples=content.samples[:, begin:end],
        times=None if content.times is None else content.times[begin:end],
        rows=content.rows[begin:end],
        labels={role: values[begin:end] for role, values in content.labels.items()},
        place=lambda axis, sample: content.place(axis, begin + sample),
    )
