"""MAT files, by scipy up to version 7 and by h5py from 7.3 on, and HDF5 files: numeric arrays by name."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, one_line
from tactogram.extras import imported
from tactogram.signal.io.archives import MIB, MOST_GROWTH, SMALL, UnpackedSizeError
from tactogram.signal.io.arrays import array_tables
from tactogram.signal.io.raw_table import RawTable

HDF5 = b"\x89HDF\r\n\x1a\n"
MOST_BYTES = 2**31
"""Unpacked size of the arrays of an HDF5 file."""
_HEAD = 128
_COMPRESSED = 15
"""Type of a compressed element (MAT-File Format, MathWorks, Level 5, table 1-1)."""


def tables(path: Path) -> list[RawTable]:
    """Return the numeric variables of a MAT file, or the datasets of an HDF5 file, as the arrays of an NPZ.

    Fields of structures and datasets in groups have their own name, after that of the structure or group where others
    have it, too (``run1.acc``). Attributes of an HDF5 file state rates and units.
    """
    with path.open("rb") as file:
        head = file.read(_HEAD)
        file.seek(512)
        second = file.read(8)
    if not head:
        raise DataError(f"{path}: empty file")
    if head.startswith((b"MATLAB 7.3", HDF5)) or second == HDF5:
        return _hdf5_tables(path, transposed=path.suffix.lower() == ".mat")
    if path.suffix.lower() != ".mat":
        raise DataError(f"{path}: not an HDF5 file: must begin with {HDF5[:4]!r}, got {head[:4]!r}")
    arrays = _named(dict(_numeric(_loaded(path))))
    if not any(values.size > 1 for values in arrays.values()):
        raise DataError(
            f"{path}: no numeric variable; tables and timetables are objects that only MATLAB reads: save their "
            "columns as variables"
        )
    return array_tables(path, arrays)


def _loaded(path: Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    with path.open("rb") as file:
        check_unpacked(file, path)
    try:
        return loadmat(path, simplify_cells=True, verify_compressed_data_integrity=True)
    except Exception as error:  # scipy raises whatever a damaged file leads to
        raise DataError(f"{path}: truncated or not a MAT file: {one_line(error)}") from None


def _hdf5_tables(path: Path, *, transposed: bool) -> list[RawTable]:
    h5py = imported("h5py", extra="formats", what="HDF5 files, and MAT files of version 7.3")
    arrays: dict[str, NDArray[np.generic]] = {}
    units: dict[str, str | None] = {}
    stated: dict[str, NDArray[np.generic]] = {}

    def visit(name: str, item: Any) -> None:
        stated.update({key: np.asarray(value) for key, value in item.attrs.items() if np.size(value) == 1})
        if not isinstance(item, h5py.Dataset) or name.startswith("#"):
            return
        if sum(each.nbytes for each in arrays.values()) + item.nbytes > MOST_BYTES:
            raise UnpackedSizeError(f"{path}: its arrays must have at most {MOST_BYTES // MIB} MiB")
        if item.dtype.kind in "fiub" or item.dtype.names:
            values = item[()]
            short = name.replace("/", ".")
            arrays[short] = values.T if transposed and values.ndim == 2 else values
            unit = item.attrs.get("unit", item.attrs.get("units"))
            units[short] = unit.decode() if isinstance(unit, bytes) else None if unit is None else str(unit)

    try:
        with h5py.File(path, "r") as file:
            visit("", file)
            file.visititems(visit)
    except UnpackedSizeError:
        raise
    except Exception as error:  # h5py raises whatever a damaged file leads to
        raise DataError(f"{path}: truncated or not an HDF5 file: {one_line(error)}") from None
    named = _named(arrays)
    by_name = dict(zip(named, units.values(), strict=True)) if any(units.values()) else None
    return array_tables(path, {**stated, **named}, units=by_name)


def _named(arrays: Mapping[str, NDArray[np.generic]]) -> dict[str, NDArray[np.generic]]:
    """Return arrays by the last part of their names where it is the only one."""
    short = Counter(name.rpartition(".")[2] for name in arrays)
    return {
        last if short[last := name.rpartition(".")[2]] == 1 else name: values
        for name, values in arrays.items()
    }


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
    try:
        while len(tag := file.read(8)) == 8:
            kind, count = (int(number) for number in np.frombuffer(tag, order))
            inner = zlib.decompressobj().decompress(file.read(count), 8) if kind == _COMPRESSED else tag
            file.seek(0 if kind == _COMPRESSED else count, 1)
            total += int(np.frombuffer(inner, order)[1])
    except (zlib.error, IndexError, ValueError) as error:
        raise DataError(f"{where}: truncated or not a MAT file: {one_line(error)}") from None
    if total > most:
        raise UnpackedSizeError(
            f"{where}: must unpack to at most {most // MIB} MiB, got {total / MIB:.0f} MiB; cut it"
        )


def _numeric(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, NDArray[np.generic]]]:
    for name, value in content.items():
        if name.startswith("__"):
            continue
        if isinstance(value, dict):
            yield from _numeric(value, f"{prefix}{name}.")
            continue
        array = (
            np.asarray(value) if isinstance(value, np.ndarray | np.generic | int | float) else np.array("")
        )
        if array.dtype.kind in "fiub" and array.ndim <= 2 and (array.ndim == 0 or array.size):
            yield f"{prefix}{name}", array
