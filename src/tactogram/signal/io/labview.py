"""LVM: text files of LabVIEW's Write To Measurement File (NI, "Specification for the LabVIEW Measurement File")."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tactogram.errors import DataError
from tactogram.signal.io.content import FileContent
from tactogram.signal.io.layout import TableLayout
from tactogram.signal.io.table import TextTable, read_lines, table_file_content

END = "***End_of_Header***"
X = "X_Value"
UNITS = {"volts": "V", "volt": "V", "newtons": "N", "newton": "N", "meters": "m", "gravities": "g"}
"""Spellings of LabVIEW for units in files."""


def read(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    axes: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
    labelled: bool = False,
) -> FileContent:
    """Return the content of an LVM file with one measurement.

    The rate is 1 / ``Delta_X``, unless time stamps contradict it or some samples are missing: then the stamps decide.
    """
    table, delta = _parse(path)
    if time is None and table.headings[0].startswith(X):
        time = table.headings[0]
    content = table_file_content(
        table, columns=columns, axes=axes, time=time, layouts=layouts, labelled=labelled
    )
    if content.times is not None and delta is not None and content.times.size:
        grid = content.times[0] + delta * np.arange(content.times.size)
        if np.abs(content.times - grid).max() > delta / 2:
            delta = None
    elif content.times is not None:
        delta = None
    return content if delta is None else replace(content, times=None, rate=1 / delta)


def headings(path: Path) -> list[str]:
    """Return the headings of the columns, with units."""
    return _parse(path)[0].headings


def _parse(path: Path) -> tuple[TextTable, float | None]:
    """Return the columns as a table, and the time between two samples if all channels have the same."""
    lines = read_lines(path)
    if not lines[0].startswith("LabVIEW Measurement"):
        raise DataError(
            f"{path}: not an LVM file: must begin with 'LabVIEW Measurement', got {lines[0][:40]!r}"
        )
    ends = [number for number, line in enumerate(lines) if line.startswith(END)]
    if len(ends) != 2:
        what = (
            "holds several measurements; save each in a file of its own"
            if len(ends) > 2
            else "has no channels"
        )
        raise DataError(f"{path}: {what}")
    separator = "," if any(line.startswith("Separator,") for line in lines[: ends[0]]) else "\t"
    facts = {key: cells for key, *cells in (line.rstrip().split(separator) for line in lines[: ends[1]])}
    comma = facts.get("Decimal_Separator") == [","] and separator != ","
    names = [name.strip() for name in lines[ends[1] + 1].split(separator)]
    kept = [i for i, name in enumerate(names) if name and name != "Comment" and (name != X or i == 0)]
    if facts.get("X_Columns", ["One"])[0] == "No":
        kept = [i for i in kept if names[i] != X]
    steps = {_number(step) for step in facts.get("Delta_X", []) if step}
    starts = {_number(start) for start in facts.get("X0", []) if start}
    if names.count(X) > 1 and max(len(steps), len(starts)) > 1:
        raise DataError(f"{path}: channels have different times; save them in files of their own")
    units = iter(facts.get("Y_Unit_Label", []))
    headings = [f"{X} [s]" if names[i] == X else _headed(names[i], next(units, "")) for i in kept]
    rows, numbers = [], []
    for number, line in enumerate(lines[ends[1] + 2 :], ends[1] + 3):
        if line.strip():
            cells = (line.replace(",", ".") if comma else line).split(separator)
            rows.append("\t".join(cells[i].strip() if i < len(cells) else "" for i in kept))
            numbers.append(number)
    if not rows or not headings:
        raise DataError(f"{path}: no rows below the heading")
    step = steps.pop() if len(steps) == 1 else math.nan
    return TextTable(path, headings, rows, numbers, [], "\t"), step if step > 0 else None


def _headed(name: str, unit: str) -> str:
    unit = unit.strip()
    return f"{name} [{UNITS.get(unit.lower(), unit)}]" if unit else name


def _number(text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return math.nan
