"""MAT files of MATLAB up to version 7 (not 7.3), read by scipy: numeric variables, also those in structures."""

from __future__ import annotations

import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError, one_line
from tactogram.signal.io.archives import MIB, MOST_GROWTH, SMALL, UnpackedSizeError
from tactogram.signal.io.arrays import array_content
from tactogram.signal.io.content import FileContent
from tactogram.signal.io.layout import TableLayout

_HEAD = 128
_COMPRESSED = 15
"""Type of a compressed element (MAT-File Format, MathWorks, Level 5, table 1-1)."""


def read(
    path: Path,
    *,
    columns: Sequence[str] | None = None,
    time: str | None = None,
    layouts: Sequence[TableLayout] = (),
) -> FileContent:
    """Return the content of a MAT file: variables of shape (time,), (axis, time) or (time, axis).

    They are chosen as the arrays of an NPZ. Fields of structures have the name of the field, after that of the
    structure where others have it, too (``run1.acc``).
    """
    return array_content(variables(path), path, columns=columns, time=time, layouts=layouts)


def variables(path: Path) -> dict[str, NDArray[np.generic]]:
    """Return the numeric variables by name, single numbers with shape ()."""
    from scipy.io import loadmat

    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not head:
        raise DataError(f"{path}: empty file")
    if head.startswith((b"MATLAB 7.3", b"\x89HDF")):
        raise DataError(f"{path}: MAT files of version 7.3 are not read; save it with save(NAME, '-v7')")
    with path.open("rb") as file:
        check_unpacked(file, path)
    try:
        content = loadmat(path, simplify_cells=True, verify_compressed_data_integrity=True)
    except Exception as error:  # scipy raises whatever a damaged file leads to
        raise DataError(f"{path}: truncated or not a MAT file: {one_line(error)}") from None
    found = dict(_numeric(content))
    short = Counter(name.rpartition(".")[2] for name in found)
    named = {
        last if short[last := name.rpartition(".")[2]] == 1 else name: values
        for name, values in found.items()
    }
    if not any(values.ndim for values in named.values()):
        raise DataError(
            f"{path}: no numeric variable; tables and timetables are objects that only MATLAB reads: save their "
            "columns as variables"
        )
    return named


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
