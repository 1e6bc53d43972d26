"""MAT files: numeric variables by name, by scipy up to version 7, later ones as HDF5 files."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal.io import hdf5
from tactogram.signal.io.archives import MIB, MOST_GROWTH, SMALL, UnpackedSizeError, decoding
from tactogram.signal.io.arrays import array_tables
from tactogram.signal.io.content import RawTable

MOST_STRUCTURES = 64
"""Elements of a list of structures that are read."""
_HEAD = 128
_COMPRESSED = 15
"""Type of a compressed element (MAT-File Format, MathWorks, Level 5, table 1-1)."""


def tables(path: Path) -> list[RawTable]:
    """Return the numeric variables of a MAT file as the arrays of an NPZ; fields of structures are ``run.acc``."""
    with path.open("rb") as file:
        head = file.read(_HEAD)
        file.seek(512)
        second = file.read(8)
    if not head:
        raise DataError(path, "empty file")
    if head.startswith((b"MATLAB 7.3", hdf5.MAGIC)) or second == hdf5.MAGIC:
        return hdf5.tables(path)
    arrays = dict(_arrays(_loaded(path)))
    if not any(values.size > 1 for values in arrays.values()):
        raise DataError(
            path,
            "no numeric variable; tables and timetables are objects that only MATLAB reads: save their "
            "columns as variables",
        )
    return array_tables(path, arrays)


def _loaded(path: Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    with path.open("rb") as file:
        check_unpacked(file, path)
    with decoding(path, "truncated or not a MAT file"):
        content = loadmat(path, simplify_cells=True, verify_compressed_data_integrity=True)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def check_unpacked(file: BinaryIO, where: Path | str, *, most_bytes: int | None = None) -> None:
    """Raise an `UnpackedSizeError` if the variables of a MAT file are too large; compressed ones state their size.

    ``most_bytes`` is by default `SMALL`, or `MOST_GROWTH` times the size of the file.
    """
    size = file.seek(0, 2)
    most = max(SMALL, MOST_GROWTH * size) if most_bytes is None else most_bytes
    file.seek(0)
    mark, total = file.read(_HEAD)[126:], 0
    if mark not in (b"IM", b"MI"):  # version 4 compresses nothing
        return
    order = "<u4" if mark == b"IM" else ">u4"
    with decoding(where, "truncated or not a MAT file"):
        while len(tag := file.read(8)) == 8:
            kind, count = (int(number) for number in np.frombuffer(tag, order))
            inner = zlib.decompressobj().decompress(file.read(count), 8) if kind == _COMPRESSED else tag
            file.seek(0 if kind == _COMPRESSED else count, 1)
            total += int(np.frombuffer(inner, order)[1])
    if total > most:
        raise UnpackedSizeError(
            where, f"must unpack to at most {most // MIB} MiB, got {total / MIB:.0f} MiB; cut it"
        )


def _arrays(value: Any, name: str = "") -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield arrays of numbers and lists of words by name, also those in structures and lists of structures."""
    if isinstance(value, Mapping):
        for field, each in value.items():
            yield from _arrays(each, f"{name}.{field}".lstrip("."))
        return
    array = np.asarray(value) if isinstance(value, np.ndarray | np.generic | int | float) else np.empty(0)
    words = array.dtype == object and all(isinstance(each, str) for each in array.flat)
    if isinstance(value, list) or (array.dtype == object and not words):
        for i, each in enumerate(value[:MOST_STRUCTURES] if np.ndim(value) == 1 else (), 1):
            yield from _arrays(each, f"{name}({i})")
    elif array.size and (words or array.dtype.kind in "fiub"):
        yield name, array
