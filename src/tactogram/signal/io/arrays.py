"""NPZ files: own ones, and arrays of foreign ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, one_line
from tactogram.signal.io.archives import check_archive
from tactogram.signal.io.columns import axis_names, time_column, time_unit_of
from tactogram.signal.io.content import ZIP_ERRORS, FileContent
from tactogram.signal.io.description import SignalDescription, decode
from tactogram.signal.io.layout import IGNORED, RATE, TIME, ColumnUse, TableLayout, layout_for
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


def read(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
) -> FileContent:
    """Return the content of an NPZ file: an array (axis, time) or (time,).

    Of a foreign file, ``columns`` names the array (or several of shape (time,), one per axis); a single array needs no
    name. ``time`` names an array of stamps in s; by default one called ``time``, ``t`` and the like.
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
    """Return the content of named arrays (axis, time) or (time,), as `read` chooses them."""
    layout = layout_for([*arrays], layouts) if columns is None else None
    if layout is not None:
        time, columns = layout.time, [*layout.axes.values()] or None
    if time is None and (layout is None or not layout.axes):
        place = time_column([*arrays], path)
        time = None if place is None else [*arrays][place]
    names = list(columns or _unnamed(arrays, time, path))
    parts = [np.atleast_2d(_numbers(arrays, name, path)) for name in names]
    if len({part.shape[1] for part in parts}) > 1:
        raise DataError(f"{path}: arrays must be equally long, got {', '.join(str(p.shape) for p in parts)}")
    samples = np.concatenate(parts)
    if samples.shape[0] > samples.shape[1] > 0:
        raise DataError(f"{path}: array must be (axis, time), got {samples.shape}; transpose it")
    axes = tuple(names) if len(names) > 1 and len(names) == len(samples) else ()
    if columns is None:
        axes = axis_names(axes) or axes
    unit, uses = None, {name: ColumnUse(name, ", ".join(axes) or SAMPLES) for name in names}
    if layout is not None:
        if len(layout.axes) == len(samples):
            axes = tuple(layout.axes)
        uses |= {name: ColumnUse(name, axis, layout.unit) for axis, name in layout.axes.items()}
        if layout.unit is not None:
            unit, factor = parse_unit(layout.unit)
            samples = samples * factor
    elif len(names) == len(axes):
        uses = {name: ColumnUse(name, axis) for name, axis in zip(names, axes, strict=True)}
    times = None
    if time is not None:
        times = _numbers(arrays, time, path)
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
        _place(names[0]),
        uses=tuple(uses.get(name, ColumnUse(name, IGNORED)) for name in arrays),
        layout=layout,
    )


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


def _unnamed(arrays: Mapping[str, NDArray[np.generic]], time: str | None, path: Path) -> list[str]:
    """Return the only array besides time stamps and single numbers, or those that are axes by their names."""
    names = [name for name in arrays if name != time and arrays[name].ndim > 0]
    if time is not None and len(names) > 1:
        names = [name for name in names if arrays[name].shape[-1] == arrays[time].size] or names
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
        what = "numbers (axis, time)" if 2 in dimensions else "a number"
        raise DataError(f"{path}: {name} must be {what}, got {dtype} of shape {shape}")
    return arrays[name].astype(np.float64)


def _place(name: str) -> Callable[[int, int], str]:
    return lambda axis, sample: f"time stamp {sample}" if axis < 0 else f"{name}[{axis}, {sample}]"
