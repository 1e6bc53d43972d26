"""NPZ and NPY files: own ones, and arrays of foreign ones, as those of MAT, HDF5 and TDMS files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, one_line
from tactogram.signal.io.archives import check_archive
from tactogram.signal.io.content import ZIP_ERRORS
from tactogram.signal.io.description import SignalDescription, decode
from tactogram.signal.io.raw_table import RawTable
from tactogram.signal.io.vocabulary import heading
from tactogram.signal.signal import Signal
from tactogram.signal.units import parse_seconds

SAMPLES = "samples"
DESCRIPTION = "tactogram"
RATE_NAMES = frozenset(
    "rate fs sf srate samplerate samplingrate samplingfrequency samplefrequency freq hz".split()
)
"""Names of a single number in Hz, in any case, without blanks and underscores."""
STEP_NAMES = frozenset("dt ts deltat sampletime samplinginterval sampleinterval wfincrement step".split())
"""The same of the time between two samples, s."""
MOST_COLUMNS = 64
"""Columns of a matrix that is taken for a recording."""

Arrays = Mapping[str, NDArray[np.generic]]


def tables(path: Path) -> list[RawTable]:
    """Return the arrays of an NPZ or NPY file: (time,), (axis, time) or (time, axis), whose longer side is the time.

    Equally long ones are one table; the columns of a matrix are ``data:1``, ``data:2``, …, those of a structured array
    its fields.
    """
    if path.suffix.lower() == ".npy":
        return array_tables(path, {path.stem: _load_array(path)})
    arrays = load_arrays(path)
    if DESCRIPTION not in arrays:
        return array_tables(path, arrays)
    description = _describe(arrays, path)
    samples = arrays.get(SAMPLES)
    if samples is None or samples.ndim != 2 or samples.dtype.kind not in "fiu":
        raise DataError(f"{path}: {SAMPLES} must be numbers (axis, time); the file was changed")
    columns = tuple(samples.astype(np.float64))
    return [RawTable(path, description.axes, columns, rate=description.rate, description=description)]


def array_tables(
    path: Path, arrays: Arrays, *, units: Mapping[str, str | None] | None = None, rate: float | None = None
) -> list[RawTable]:
    """Return named arrays as tables, the longest first; a single number named as a rate or step states the rate."""
    rate_name = None
    for name, values in arrays.items():
        if values.size == 1 and values.dtype.kind in "fiu":
            stated = _rate(name, float(values.ravel()[0]))
            rate_name, rate = (rate_name, rate) if stated is None else (name, stated)
    columns: dict[str, tuple[str, NDArray[np.generic]]] = {}
    refused = []
    for name, values in arrays.items():
        if values.size == 1 or name == rate_name:
            continue
        found = _columns(name, values)
        if not found:
            refused.append(f"{name} is {values.dtype} of shape {values.shape}")
        columns |= {column: (name, each) for column, each in found.items()}
    lengths = sorted({len(values) for _, values in columns.values()}, reverse=True)
    if not any(lengths):
        what = "; ".join(refused) or ("no samples" if columns else "no arrays")
        raise DataError(
            f"{path}: must hold numbers (axis, time) with at most {MOST_COLUMNS} axes, got {what}"
        )
    tables = []
    for length in lengths:
        alike = {name: each for name, each in columns.items() if len(each[1]) == length}
        tables.append(
            RawTable(
                path,
                tuple(alike),
                tuple(_numbers(values) for _, values in alike.values()),
                units=tuple((units or {}).get(name) for name in alike) if units else (),
                groups=tuple(group for group, _ in alike.values()),
                rate=rate,
                rate_name=rate_name,
            )
        )
    return tables


def _rate(name: str, number: float) -> float | None:
    """Return the rate in Hz that a number states by its name, as ``fs``, ``Sample_Rate_Hz`` or ``dt_ms``."""
    found = heading(name)
    plain = "".join(found.words)
    if plain.removesuffix("hz") in RATE_NAMES or plain in RATE_NAMES:
        return number
    seconds = parse_seconds(found.unit or "s") or 1.0
    return 1 / (number * seconds) if plain in STEP_NAMES and number > 0 else None


def _columns(name: str, values: NDArray[np.generic]) -> dict[str, NDArray[np.generic]]:
    """Return the columns of an array by name; none if it is no recording."""
    if values.dtype.names:
        fields = {each: values[each].ravel() for each in values.dtype.names}
        return {each: field for each, field in fields.items() if field.dtype.kind in "fiubSUO"}
    if values.dtype.kind not in "fiub" or values.ndim not in (1, 2):
        return {}
    if values.ndim == 1 or 1 in values.shape:
        return {name: values.ravel()}
    rows = values.T if len(values) > values.shape[1] else values
    return {f"{name}:{i}": row for i, row in enumerate(rows, 1)} if len(rows) <= MOST_COLUMNS else {}


def _numbers(values: NDArray[np.generic]) -> NDArray[np.float64] | NDArray[np.object_]:
    if values.dtype.kind in "fiub":
        return values.astype(np.float64)
    column = np.empty(len(values), dtype=object)
    column[:] = [each.decode("utf-8", "replace") if isinstance(each, bytes) else each for each in values]
    return column


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


def _describe(arrays: Arrays, path: Path) -> SignalDescription:
    found = decode(str(arrays[DESCRIPTION]), str(path))
    if found is None:
        raise DataError(f"{path}: description is damaged")
    return found


def _load_array(path: Path) -> NDArray[np.generic]:
    try:
        with path.open("rb") as file:
            if not file.read(1):
                raise DataError(f"{path}: empty file")
        loaded: NDArray[np.generic] = np.load(path, mmap_mode="r", allow_pickle=False)
    except (ValueError, OSError, EOFError) as error:
        reason = "holds pickled objects" if "allow_pickle" in str(error) else "truncated or not an NPY file"
        raise DataError(f"{path}: {reason}: {one_line(error)}") from error
    return loaded
