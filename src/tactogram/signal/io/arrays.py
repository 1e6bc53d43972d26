"""NPZ files: own ones, and arrays of foreign ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, one_line
from tactogram.signal.io.archives import check_archive
from tactogram.signal.io.columns import axis_names, time_column, time_unit_of
from tactogram.signal.io.content import ZIP_ERRORS, FileContent, default_axes
from tactogram.signal.io.description import SignalDescription, decode
from tactogram.signal.io.layout import IGNORED, RATE, TIME, UNCLEAR, ColumnUse, TableLayout, layout_for
from tactogram.signal.signal import Signal
from tactogram.signal.units import parse_seconds, parse_unit

SAMPLES = "samples"
DESCRIPTION = "tactogram"
RATE_NAMES = (
    "rate",
    "fs",
    "sf",
    "srate",
    "samplerate",
    "samplingrate",
    "samplingfrequency",
    "samplefrequency",
)
"""Names of a single number in Hz, in any case, with or without underscores."""
STEP_NAMES = ("dt", "ts", "deltat", "sampletime", "samplinginterval")
"""The same of the time between two samples, s."""
MOST_COLUMNS = 64
"""Columns of a matrix that is taken for a recording."""


def read(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
) -> FileContent:
    """Return the content of an NPZ file: an array (axis, time), (time, axis) or (time,), whose longer side is the time.

    Of a foreign file, ``columns`` names the array (or several of shape (time,), one per axis); a single array needs no
    name. ``time`` names an array of stamps in s; by default one called ``time``, ``t`` and the like. The columns of a
    matrix are named ``data:1``, ``data:2``, ….
    """
    arrays = load_arrays(path)
    if DESCRIPTION in arrays:
        description = _describe(arrays, path)
        samples = _numbers(arrays, SAMPLES, path)
        return FileContent(
            samples, description.axes, description.rate, None, description.unit, description, _place(SAMPLES)
        )
    return array_content(arrays, path, columns=columns, time=time, layouts=layouts)


def array_content(
    arrays: Mapping[str, NDArray[np.generic]],
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
) -> FileContent:
    """Return the content of named arrays, as `read` chooses them; `array_columns` names their columns."""
    found = array_columns(arrays)
    layout = layout_for([*found], layouts) if columns is None else None
    if layout is not None and layout.labels:
        raise DataError(f"{path}: columns of labels are read from tables, not from arrays; save it as .csv")
    if layout is not None:
        time, columns = layout.time, [*layout.axes.values()] or None
    if time is None and (layout is None or not layout.axes):
        place = time_column([*found], path)
        time = None if place is None else [*found][place]
    chosen = list(columns or _unnamed(arrays, time, path))
    names = [name for each in chosen for name in _columns_of(arrays, each) if name != time]
    parts = [_numbers(found, name, path, dimensions=(1,)) for name in names]
    if len({len(part) for part in parts}) > 1:
        raise DataError(f"{path}: arrays must be equally long, got {', '.join(str(p.shape) for p in parts)}")
    samples = np.stack(parts)
    axes = tuple(chosen) if 1 < len(chosen) == len(names) else default_axes(len(names))
    if columns is None:
        axes = axis_names(axes) or axes
    unit = spelled = None
    if layout is not None:
        axes, spelled = tuple(layout.axes) or axes, layout.unit
    if spelled is not None:
        unit, factor = parse_unit(spelled)
        samples = samples * factor
    uses = {name: ColumnUse(name, axis, spelled) for name, axis in zip(names, axes, strict=True)}
    times = None
    if time is not None:
        times = _numbers(found, time, path, dimensions=(1,))
        if times.shape != (samples.shape[1],):
            raise DataError(f"{path}: {time} must have shape ({samples.shape[1]},), got {times.shape}")
        time_unit = (layout and layout.time_unit) or time_unit_of(time) or "s"
        times = times * (parse_seconds(time_unit) or 1.0)
        uses[time] = ColumnUse(time, TIME, time_unit)
    if rate := _rate(arrays, path):
        uses[rate[0]] = ColumnUse(rate[0], RATE)
    return FileContent(
        samples,
        axes,
        rate and rate[1],
        times,
        unit,
        None,
        lambda axis, sample: f"time stamp {sample}" if axis < 0 else f"{names[axis]}[{sample}]",
        uses=tuple(uses.get(name, ColumnUse(name, IGNORED)) for name in found),
        layout=layout,
    )


def array_columns(arrays: Mapping[str, NDArray[np.generic]]) -> dict[str, NDArray[np.generic]]:
    """Return vectors and single numbers by name, and the columns of a matrix as ``data:1``, ``data:2``, ….

    Its longer side is the time. A matrix with more than `MOST_COLUMNS` stays as it is.
    """
    found: dict[str, NDArray[np.generic]] = {}
    for name, values in arrays.items():
        names = _columns_of(arrays, name)
        if values.ndim == 2 and min(values.shape) <= MOST_COLUMNS:
            rows = values.T if len(values) > values.shape[1] else values
            found |= dict(zip(names, rows, strict=True))
        else:
            found[name] = values
    return found


def array_uses(arrays: Mapping[str, NDArray[np.generic]], path: Path) -> tuple[ColumnUse, ...]:
    """Return time stamps and rate, as their names say, and all other columns as `UNCLEAR`."""
    names = [*array_columns(arrays)]
    time, rate = time_column(names, path), _rate(arrays, path)
    roles = {names[time]: TIME} if time is not None else {}
    roles |= {rate[0]: RATE} if rate else {}
    return tuple(ColumnUse(name, roles.get(name, UNCLEAR)) for name in names)


def describe(path: Path) -> SignalDescription | None:
    """Return the description in the file, if there is one."""
    arrays = load_arrays(path, only=DESCRIPTION)
    return _describe(arrays, path) if DESCRIPTION in arrays else None


def write(path: Path, signal: Signal, description: SignalDescription) -> None:
    """Write the samples as float32 (axis, time), and the description as text."""
    with path.open("wb") as file:
        np.savez(file, samples=signal.samples, tactogram=np.array(description.encode()))


def load_arrays(
    path: Path, *, only: str | None = None, needed: Sequence[str] = ()
) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of an NPZ file by name, or only one of them; their size is checked before they are unpacked.

    Raises
    ------
    DataError
        If it is not an NPZ file, is truncated, holds objects, lacks one of the arrays ``needed``, or unpacks to more
        than `check_archive` allows.
    """
    with path.open("rb") as stream:
        head = stream.read(6)
        if not head:
            raise DataError(f"{path}: empty file")
        if not head.startswith(b"PK"):
            hint = "; save it with numpy.savez" if head == b"\x93NUMPY" else ""
            raise DataError(f"{path}: not an NPZ file: expected PK at byte 0, got {head!r}{hint}")
        check_archive(stream, path)
        stream.seek(0)
        try:
            with np.load(stream, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files if only is None or name == only}
        except (*ZIP_ERRORS, ValueError, KeyError) as error:
            reason = "holds pickled objects" if "allow_pickle" in str(error) else "truncated or damaged"
            raise DataError(f"{path}: {reason}: {one_line(error)}") from error
    if missing := [name for name in needed if name not in arrays]:
        raise DataError(f"{path}: must hold {', '.join(needed)}, lacks {', '.join(missing)}")
    return arrays


def _describe(arrays: dict[str, NDArray[np.generic]], path: Path) -> SignalDescription:
    found = decode(str(arrays[DESCRIPTION]), str(path))
    if found is None:
        raise DataError(f"{path}: description is damaged")
    return found


def _columns_of(arrays: Mapping[str, NDArray[np.generic]], name: str) -> list[str]:
    """Return the names of an array's columns; the name itself if it is a column, or there is no such array."""
    values = arrays.get(name)
    count = min(values.shape) if values is not None and values.ndim == 2 else 1
    return [f"{name}:{i}" for i in range(1, count + 1)] if 1 < count <= MOST_COLUMNS else [name]


def _unnamed(arrays: Mapping[str, NDArray[np.generic]], time: str | None, path: Path) -> list[str]:
    """Return the only array besides time stamps and single numbers, or those that are axes by their names."""
    names = [name for name in arrays if name != time and arrays[name].ndim > 0]
    if time is not None and time in arrays and len(names) > 1:
        names = [name for name in names if max(arrays[name].shape) == arrays[time].size] or names
    if len(names) == 1 or (names and axis_names(names) and all(arrays[name].ndim == 1 for name in names)):
        return names
    raise DataError(f"{path}: which array? choose of {', '.join(arrays) or 'none'}")


def _rate(arrays: Mapping[str, NDArray[np.generic]], path: Path) -> tuple[str, float] | None:
    """Return name and value in Hz of the single number that is the rate."""
    for name, values in arrays.items():
        plain = name.lower().replace("_", "")
        if values.shape == () and plain in (*RATE_NAMES, *STEP_NAMES):
            number = float(_numbers(arrays, name, path, dimensions=(0,)))
            return name, 1 / number if plain in STEP_NAMES and number > 0 else number
    return None


def _numbers(
    arrays: Mapping[str, NDArray[np.generic]], name: str, path: Path, *, dimensions: Sequence[int] = (1, 2)
) -> NDArray[np.float64]:
    if name not in arrays:
        raise DataError(f"{path}: no array {name!r}, there are {', '.join(arrays)}")
    if arrays[name].dtype.kind not in "fiub" or arrays[name].ndim not in dimensions:
        shape, dtype = arrays[name].shape, arrays[name].dtype
        what = "numbers (axis, time)" if 0 not in dimensions else "a number"
        what += f" with at most {MOST_COLUMNS} axes" if arrays[name].ndim == 2 not in dimensions else ""
        raise DataError(f"{path}: {name} must be {what}, got {dtype} of shape {shape}")
    return arrays[name].astype(np.float64)


def _place(name: str) -> Callable[[int, int], str]:
    return lambda axis, sample: f"time stamp {sample}" if axis < 0 else f"{name}[{axis}, {sample}]"
