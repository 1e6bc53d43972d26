"""LVM and TDMS: measurement files of LabVIEW and other programs of National Instruments."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError, one_line
from tactogram.extras import imported
from tactogram.signal.io.arrays import array_tables
from tactogram.signal.io.raw_table import RawTable

X = "X_Value"


def lvm_tables(path: Path) -> list[RawTable]:
    """Return the channels of an LVM file, a table for each of its segments; lvm_read knows their header.

    The rate is 1 / ``Delta_X`` if all channels have the same.
    """
    lvm_read = imported("lvm_read", extra="formats", what="LVM files")
    with path.open("rb") as file:
        head = file.read(40).decode("latin-1").partition("\n")[0].rstrip()
    if not head.startswith("LabVIEW Measurement"):
        raise DataError(f"{path}: not an LVM file: must begin with 'LabVIEW Measurement', got {head!r}")
    try:
        content = lvm_read.read(str(path), read_from_pickle=False, dump_file=False)
    except Exception as error:  # it raises whatever a damaged file leads to
        raise DataError(f"{path}: truncated or not an LVM file: {one_line(error)}") from None
    without = content.get("X_Columns") == "No"
    found = [_segment(path, content[i], without_x=without) for i in range(content.get("Segments", 0))]
    if not any(len(table) for table in found):
        raise DataError(f"{path}: no rows below the heading")
    return found


def _segment(path: Path, segment: dict[str, Any], *, without_x: bool) -> RawTable:
    values = np.atleast_2d(np.asarray(segment["data"], dtype=np.float64))
    names = [name.strip() for name in segment["Channel names"]]
    if without_x and len(values.T) < len(names):
        names = [name for name in names if name != X]
    names = names[: values.shape[1]]
    labels = [label.strip() for label in segment.get("Y_Unit_Label", [])]
    channels = [i for i, name in enumerate(names) if name not in ("", X, "Comment")]
    stated = [label for label in labels if label]
    if len(stated) != len(channels):  # one above each channel, from the second column on
        stated = [dict(enumerate(labels, int(names[0] == X))).get(i, "") for i in channels]
    units = {i: label or None for i, label in zip(channels, stated, strict=True)}
    kept = [i for i, name in enumerate(names) if name and not np.isnan(values[:, i]).all()]
    steps = {step for step in segment.get("Delta_X", []) if step > 0}
    return RawTable(
        path,
        tuple(names[i] for i in kept),
        tuple(values[:, i] for i in kept),
        units=tuple("s" if names[i] == X else units.get(i) for i in kept),
        rate=1 / steps.pop() if len(steps) == 1 else None,
        rate_name="Delta_X",
    )


def tdms_tables(path: Path) -> list[RawTable]:
    """Return the channels of a TDMS file, a table for each group, length and rate; npTDMS reads them."""
    nptdms = imported("nptdms", extra="formats", what="TDMS files")
    try:
        file = nptdms.TdmsFile.read(path)
        channels = [(group.name, channel) for group in file.groups() for channel in group.channels()]
        columns = {
            (group, channel.properties.get("wf_increment"), channel.name): (channel[:], channel.properties)
            for group, channel in channels
        }
    except Exception as error:  # it raises whatever a damaged file leads to
        raise DataError(f"{path}: truncated or not a TDMS file: {one_line(error)}") from None
    tables = []
    for group, step in dict.fromkeys((group, step) for group, step, _ in columns):
        named = {name: each for (g, s, name), each in columns.items() if (g, s) == (group, step)}
        arrays = {name: values for name, (values, _) in named.items()}
        units = {
            name: facts.get("unit_string") or facts.get("NI_UnitDescription") or None
            for name, (_, facts) in named.items()
        }
        rate = 1 / float(step) if step and step > 0 else None
        tables += array_tables(path, arrays, units=units, rate=rate)
    return tables
