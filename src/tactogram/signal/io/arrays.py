"""NPZ and NPY files: own ones, and arrays of foreign ones, as those of MAT, HDF5 and TDMS files."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal.io.archives import check_archive, decoding
from tactogram.signal.io.content import Column, RawTable, SignalDescription, decode
from tactogram.signal.io.vocabulary import heading
from tactogram.signal.signal import Signal
from tactogram.signal.units import parse_seconds

SAMPLES = "samples"
DESCRIPTION = "tactogram"
RATE_NAMES = frozenset(
    [
        *("rate", "fs", "sf", "sr", "srate", "fsamp", "freq", "hz"),
        *("samplerate", "samplingrate", "samplefrequency", "samplingfrequency"),
    ]
)
"""Names of a single number in Hz, in any case, without blanks and underscores."""
STEP_NAMES = frozenset(
    [
        *("dt", "ts", "deltat", "sampletime", "wfincrement", "step"),
        *("samplinginterval", "sampleinterval", "samplingperiod"),
    ]
)
"""The same of the time between two samples, s."""
MOST_COLUMNS = 64
"""Columns of a matrix that is taken for a recording."""
FEWEST = 10
"""Samples of a recording; fewer beside one that has as many are settings."""
MOST_LISTED = 6

Arrays = Mapping[str, NDArray[Any]]


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
        raise DataError(path, f"{SAMPLES} must be numbers (axis, time); the file was changed")
    columns = tuple(samples.astype(np.float64))
    return [RawTable(path, description.axes, columns, rate=description.rate, description=description)]


def array_tables(
    path: Path, arrays: Arrays, *, units: Mapping[str, str | None] | None = None, rate: float | None = None
) -> list[RawTable]:
    """Return named arrays as tables, the longest first: one for each length and rate.

    A single number that is named as a rate or step holds for the arrays beside it, in its group (``run.fs``), or of its
    name (``acc/fs``). What is no column is named in a note.
    """
    fields = dict(_fields(arrays))
    singles = {name: values for name, values in fields.items() if values.size == 1}
    rates = {name: hz for name, values in singles.items() if (hz := _rate(name, values)) is not None}
    short = _short([name for name in fields if name not in rates])
    blocks: dict[tuple[int, str | None], dict[str, tuple[str, Column, str | None]]] = {}
    refused: list[str] = []
    for name, values in fields.items():
        if name in singles:
            continue
        if columns := array_columns(short[name], values):
            unit = "s" if values.dtype.kind in "mM" else (units or {}).get(name)
            alike = blocks.setdefault((len(next(iter(columns.values()))), _rate_of(name, rates)), {})
            alike |= {text: (short[name], column, unit) for text, column in columns.items()}
        else:
            refused.append(f"{name} is {values.dtype} of shape {values.shape}")
    if not any(
        column.dtype != object and len(column) for alike in blocks.values() for _, column, _ in alike.values()
    ):
        refused += [f"{name} is {values.dtype} of shape {values.shape}" for name, values in singles.items()]
        what = "no samples" if blocks else ", ".join(refused[:MOST_LISTED]) or "no arrays"
        raise DataError(path, f"must hold numbers (axis, time) with at most {MOST_COLUMNS} axes, got {what}")
    settings = [name for name in singles if name not in rates]
    longest = max(length for length, _ in blocks)
    for key, alike in [*blocks.items()]:
        timed = len(_parts(key[1] or "")) > 1 or any(heading(text).is_clock for text in alike)
        if not timed and key[0] < FEWEST <= longest:
            settings += blocks.pop(key)
    notes = [f"left out: {', '.join(each[:MOST_LISTED])}{' …' * (len(each) > MOST_LISTED)}{what}"
             for each, what in ((refused, ""), (settings, " (single values)")) if each]  # fmt: skip
    tables = []
    for (_, rate_name), alike in sorted(blocks.items(), key=lambda item: -item[0][0]):
        groups, parts, spelled = zip(*alike.values(), strict=True)
        tables.append(
            RawTable(
                path,
                tuple(alike),
                parts,
                units=spelled if any(spelled) else (),
                groups=groups,
                rate=rate if rate_name is None else rates[rate_name],
                rate_name=rate_name,
                notes=tuple(notes),
            )
        )
    return tables


def _fields(arrays: Arrays) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield arrays by name, and the fields of structured ones."""
    for name, values in arrays.items():
        if values.dtype.names:
            parts = {
                f"{name}.{field}" if len(arrays) > 1 else field: values[field] for field in values.dtype.names
            }
            yield from _fields(
                {text: part.ravel() if values.ndim > 1 else part for text, part in parts.items()}
            )
        else:
            yield name, values


def _short(names: Sequence[str]) -> dict[str, str]:
    """Return names without the groups that they are in, where these name no quantity and the rest is the only one."""
    last = Counter(_parts(name)[-1] for name in names)
    named = {name: heading(" ".join(_parts(name)[:-1])).quantity is not None for name in names}
    return {name: name if named[name] or last[_parts(name)[-1]] > 1 else _parts(name)[-1] for name in names}


def _rate(name: str, values: NDArray[np.generic]) -> float | None:
    """Return the rate in Hz that a number states by its name, as ``fs``, ``Sample_Rate_Hz`` or ``dt_ms``."""
    parsed = heading(_parts(name)[-1])
    plain = "".join(parsed.words)
    per_second = plain in RATE_NAMES or plain.removesuffix("hz").removesuffix("k") in RATE_NAMES
    if values.dtype.kind not in "fiu" or (not per_second and plain not in STEP_NAMES):
        return None
    number = float(values.ravel()[0])
    if per_second:
        return number * (1e3 if plain.endswith("khz") or (parsed.unit or "").lower() == "khz" else 1.0)
    seconds = number * (parse_seconds(parsed.unit or "s") or 1.0)
    return 1 / seconds if seconds > 0 else None


def _rate_of(name: str, rates: Mapping[str, float]) -> str | None:
    """Return the name of the rate of an array: of its own, else beside it, else of the groups around it."""
    groups = {name: _parts(name)[:-1] for name in rates}
    parts = _parts(name)
    for depth in range(len(parts), -1, -1):
        if inside := [rate for rate, group in groups.items() if group == parts[:depth]]:
            return inside[0]
    return None


def _parts(name: str) -> list[str]:
    return re.split(r"[./]", name)


def array_columns(name: str, values: NDArray[Any]) -> dict[str, Column]:
    """Return the columns of an array by name; none if it is no recording. Dates are seconds from the first."""
    if values.ndim == 2 and 1 in values.shape:
        values = values.ravel()
    if values.ndim == 1 and values.dtype.kind in "mM":
        since = values - values[:1] if values.dtype.kind == "M" else values
        return {name: np.where(np.isnat(since), np.nan, since.astype("m8[ns]").astype(np.float64) * 1e-9)}
    if values.ndim == 1 and values.dtype.kind in "USO":
        texts = [each.decode("utf-8", "replace") if isinstance(each, bytes) else each for each in values]
        column = np.empty(len(texts), dtype=object)
        column[:] = texts
        return {name: column} if all(isinstance(each, str) for each in texts) else {}
    if values.dtype.kind not in "fiub" or values.ndim not in (1, 2):
        return {}
    if values.ndim == 1:
        return {name: values.astype(np.float64)}
    rows = values.T if len(values) >= values.shape[1] else values
    return (
        {f"{name}:{i}": row.astype(np.float64) for i, row in enumerate(rows, 1)}
        if len(rows) <= MOST_COLUMNS
        else {}
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

    Raises `DataError` if it is not an NPZ file, is truncated, holds objects, lacks one of the arrays ``needed``, or
    unpacks to more than `check_archive` allows.
    """
    with path.open("rb") as stream:
        head = stream.read(6)
        if not head:
            raise DataError(path, "empty file")
        if not head.startswith(b"PK"):
            hint = "; save it with numpy.savez" if head == b"\x93NUMPY" else ""
            raise DataError(path, f"not an NPZ file: expected PK at byte 0, got {head!r}{hint}")
        check_archive(stream, path)
        stream.seek(0)
        with decoding(path, "truncated or damaged"), np.load(stream, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files if only is None or name == only}
    if missing := [name for name in needed if name not in arrays]:
        raise DataError(path, f"must hold {', '.join(needed)}, lacks {', '.join(missing)}")
    return arrays


def _describe(arrays: Arrays, path: Path) -> SignalDescription:
    description = decode(str(arrays[DESCRIPTION]), str(path))
    if description is None:
        raise DataError(path, "description is damaged")
    return description


def _load_array(path: Path) -> NDArray[np.generic]:
    with decoding(path, "truncated or not an NPY file"):
        # Mapped, so that a head that claims more than there is takes no memory.
        loaded: NDArray[np.generic] = np.lib.format.open_memmap(path, mode="r")
    return loaded
