"""LVM and TDMS: measurement files of LabVIEW and other programs of National Instruments.

The rows of LVM are read as those of any text table; here is its header alone (NI, "Specification for the LabVIEW
Measurement File"). lvm-read turns cells that are no numbers into NaN without a word, does not number rows, and leaves
units, channels of several rates and segments to its caller.
"""

from __future__ import annotations

import logging
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError, UnitError
from tactogram.extras import imported
from tactogram.signal.io import table
from tactogram.signal.io.archives import decoding
from tactogram.signal.io.arrays import array_columns
from tactogram.signal.io.content import RawTable
from tactogram.signal.units import parse_unit
from tactogram.text_files import detected_text

END = "***End_of_Header***"
X = "X_Value"
_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}


def lvm_tables(path: Path) -> list[RawTable]:
    """Return a table of each measurement; those of the same channels are one, whose time goes on or back.

    The rate is 1 / ``Delta_X``, for time stamps to confirm. A file without headers is a text table.
    """
    raw = path.read_bytes()
    if not raw:
        raise DataError(path, "empty file")
    lines = detected_text(raw, path)[0].removeprefix("\ufeff").splitlines()
    if not any(line.startswith(END) for line in lines):  # written without headers
        return [table.text_table(path, re.sub(rb"\bX_Value\b(?! *\[)", X.encode() + b" [s]", raw))]
    if not lines[0].startswith("LabVIEW Measurement"):
        raise DataError(
            path, f"not an LVM file: must begin with 'LabVIEW Measurement', got {lines[0][:40]!r}"
        )
    named = next((line[9:] for line in lines[:30] if line.startswith("Separator")), "\tTab")
    separator = _SEPARATORS.get(named.strip(" \t,;").lower(), named[:1])
    ends = [number for number, line in enumerate(lines) if line.startswith(END)]
    starts = [number for number, line in enumerate(lines) if line.startswith(f"Channels{separator}")]
    if not starts or len(ends) < 2:
        raise DataError(path, "has no channels")
    facts = _facts(lines[: starts[0]], separator)
    comma = facts.get("Decimal_Separator", [""])[0] == "," and separator != ","
    timed = facts.get("X_Columns", ["One"])[0] != "No"
    tables: list[RawTable] = []
    for start, stop in zip(starts, [*starts[1:], len(lines)], strict=True):
        end = next((number for number in ends if start < number < stop - 1), None)
        if end is None:
            raise DataError(f"{path}: row {start + 1}", "no rows below this header")
        rows = [line.replace(",", ".") if comma else line for line in lines[end + 1 : stop]]
        cells = [[cell.strip() for cell in line.split(separator)] for line in rows]
        tables += _measurement(path, cells, end + 1, _facts(lines[start:end], separator), timed=timed)
    return _joined(tables)


def _facts(lines: Sequence[str], separator: str) -> dict[str, list[str]]:
    return {
        key: [cell.strip() for cell in cells] for key, *cells in (line.split(separator) for line in lines)
    }


def _measurement(
    path: Path, cells: Sequence[Sequence[str]], above: int, facts: dict[str, list[str]], *, timed: bool
) -> list[RawTable]:
    """Return the channels of one measurement, from its heading on: one table, or without times one for each rate."""
    names = cells[0]
    channels = [i for i, name in enumerate(names) if name not in ("", X, "Comment")]
    times = [i for i, name in enumerate(names) if name == X] if timed else []
    spelled = {tuple(row[i] if i < len(row) else "" for row in cells): i for i in reversed(times)}
    times = sorted(spelled.values())  # those of channels that are sampled together are one

    def fact(key: str) -> dict[int, str]:
        """Return a fact by channel: they stand above the channels from the second column on, or side by side."""
        stated = facts.get(key, [])
        if sum(map(bool, stated)) == len(channels):
            return dict(zip(channels, filter(None, stated), strict=True))
        return {i: stated[i - 1] if 0 < i <= len(stated) else "" for i in channels}

    steps, units = fact("Delta_X"), fact("Y_Unit_Label")
    groups = (
        [channels]
        if times
        else [[i for i in channels if steps[i] == step] for step in dict.fromkeys(steps.values())]
    )
    tables = []
    for group in groups:
        kept = sorted([*times, *group])
        heads = [f"{X} [s]" if i in times else _headed(names[i], units[i]) for i in kept]
        rows = [[row[i] if i < len(row) else "" for i in kept] for row in cells[1:]]
        if not any(map(any, rows)):
            raise DataError(path, "no rows below the heading")
        text = "\n".join(
            ["\n" * (above - 1), *("\t".join(row) if any(row) else "" for row in [heads, *rows]), ""]
        )
        delta = {steps[i] for i in group}
        step = _number(delta.pop()) if len(delta) == 1 else 0.0
        read = table.text_table(path, text.encode())
        written = max(map(_number, facts.get("Samples", [])), default=0.0)
        notes = read.notes
        if not times and len(read) > written > 0:
            notes = (
                *notes,
                f"{len(read)} rows, written {written:.0f} at a time: taken for one recording without pauses",
            )
        tables.append(replace(read, rate=1 / step if step > 0 else None, rate_name="Delta_X", notes=notes))
    return tables


def _joined(tables: Sequence[RawTable]) -> list[RawTable]:
    joined: list[RawTable] = []
    for each in tables:
        last = joined[-1] if joined else None
        if last is None or last.headings != each.headings or not each.headings[0].startswith(X):
            joined.append(each)
            continue
        columns: list[Any] = [np.concatenate(both) for both in zip(last.columns, each.columns, strict=True)]
        rate = last.rate if last.rate == each.rate else None
        joined[-1] = replace(last, columns=tuple(columns), rows=[*last.rows, *each.rows], rate=rate)
    return joined


def _headed(name: str, unit: str) -> str:
    """Return a heading with a unit, which is the one of a signal if it is the same, such as V for Volts."""
    try:
        known, factor = parse_unit(unit)
    except UnitError:
        return f"{name} [{unit}]" if unit else name
    return f"{name} [{known if factor == 1 else unit}]"


def _number(text: str) -> float:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return 0.0


def tdms_tables(path: Path) -> list[RawTable]:
    """Return the channels of a TDMS file, a table for each group, length and rate; npTDMS reads them."""
    nptdms = imported("nptdms", extra="formats", what="TDMS files")
    logging.getLogger("nptdms").setLevel(logging.CRITICAL)  # what it warns of is noted below
    size = path.stat().st_size
    with (
        decoding(path, "truncated or not a TDMS file"),
        path.open("rb") as stream,
        nptdms.TdmsFile.open(stream) as file,
    ):
        channels = [channel for group in file.groups() for channel in group.channels()]
        claimed = sum(map(len, channels))
        cut = file.file_status.incomplete_final_segment
        read = [
            (each.group_name, each.properties, each.name, each[:]) for each in channels if claimed <= size
        ]
    if claimed > size:
        raise DataError(path, f"damaged: claims {claimed} samples in {size} bytes")
    names = Counter(name for _, _, name, _ in read)
    if cut:  # channels of the last segment end alike
        whole = {key: min(len(v) for g, f, _, v in read if (g, f.get("wf_increment")) == key) for key in
                 {(g, f.get("wf_increment")) for g, f, _, _ in read}}  # fmt: skip
        read = [(g, f, name, values[: whole[g, f.get("wf_increment")]]) for g, f, name, values in read]
    tables: dict[tuple[object, ...], RawTable] = {}
    for group, facts, name, values in read:
        text = name if names[name] == 1 else f"{group}/{name}"
        step = facts.get("wf_increment")
        for heading, column in array_columns(text, np.asarray(values)).items():
            key = (group, len(column), step, facts.get("wf_start_offset"))
            last = tables.get(
                key, RawTable(path, (), (), rate=1 / float(step) if step and step > 0 else None)
            )
            unit = facts.get("unit_string") or facts.get("NI_UnitDescription") or None
            unit = "s" if values.dtype.kind in "mM" else unit
            tables[key] = replace(
                last,
                headings=(*last.headings, heading),
                columns=(*last.columns, column),
                units=(*last.units, unit),
            )
    if not any(map(len, tables.values())):
        raise DataError(path, "no samples")
    notes = ("last segment is cut off: what is there is read",) if cut else ()
    return [replace(each, rate_name="wf_increment", notes=notes) for each in tables.values() if len(each)]
