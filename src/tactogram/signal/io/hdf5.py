"""HDF5 files, also MAT files of version 7.3, by h5py: datasets by path, with the rates and units in attributes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.extras import imported
from tactogram.signal.io.archives import check_size, decoding
from tactogram.signal.io.arrays import array_tables
from tactogram.signal.io.content import RawTable

MAGIC = b"\x89HDF\r\n\x1a\n"
UNITS = ("unit", "units", "unit_string")
COLUMNS = ("columns", "column_names", "channels", "channel_names", "labels", "names", "axes", "fields")
"""Attributes of a dataset, in lower case: its unit or those of its columns, and the names of these."""


def tables(path: Path) -> list[RawTable]:
    """Return the datasets of a file as the arrays of an NPZ.

    Attributes of a dataset, of its groups and of the file state rate and units. Links to other files are not followed,
    and references, which MATLAB writes for its cells, not read.
    """
    h5py = imported("h5py", extra="formats", what="HDF5 files, and MAT files of version 7.3")
    items: dict[str, Any] = {}
    arrays: dict[str, NDArray[Any]] = {}
    units: dict[str, str | None] = {}
    with decoding(path, "truncated or not an HDF5 file"), h5py.File(path, "r") as file:
        file.visititems(items.__setitem__)
        data = {name: item for name, item in items.items() if _is_read(name, item, h5py)}
        check_size(sum(item.nbytes for item in data.values()), path)
        for name, item in {"": file, **items}.items():
            stated = {key: np.asarray(value) for key, value in item.attrs.items()}
            numbers = {k: v for k, v in stated.items() if v.size == 1 and v.dtype.kind in "fiu"}
            arrays |= {f"{name}/{key}".lstrip("/"): value for key, value in numbers.items()}
        for name, item in data.items():
            attributes = {key.lower(): value for key, value in item.attrs.items()}
            text = h5py.check_string_dtype(item.dtype) is not None
            values = np.asarray(item.asstr()[()] if text and item.ndim else item[()])
            transposed = "MATLAB_class" in item.attrs and values.ndim == 2
            parts = _parts(name, values.T if transposed else values, attributes)
            spelled = _words(attributes, UNITS)
            spelled = spelled * len(parts) if len(spelled) == 1 else spelled
            arrays |= parts
            units |= dict(zip(parts, spelled, strict=True)) if len(spelled) == len(parts) else {}
    if not any(
        values.dtype.names or (values.dtype.kind in "fiub" and values.size > 1) for values in arrays.values()
    ):
        raise DataError(
            path,
            "no numbers; MATLAB's tables and cells are objects that it alone reads: save them as variables",
        )
    return array_tables(path, arrays, units=units)


def _is_read(name: str, item: Any, h5py: Any) -> bool:
    """Return whether an item holds numbers or words in this file; those below ``#`` are MATLAB's own."""
    if not isinstance(item, h5py.Dataset) or name.startswith("#") or item.shape is None:
        return False
    if item.external or item.is_virtual or item.attrs.get("MATLAB_class") in (b"char", b"cell"):
        return False
    return "MATLAB_empty" not in item.attrs and (
        item.dtype.kind != "O" or h5py.check_string_dtype(item.dtype) is not None
    )


def _parts(name: str, values: NDArray[Any], attributes: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """Return the columns of a matrix by their names, if the attributes state these; else the array."""
    names = _words(attributes, COLUMNS)
    if values.ndim != 2 or len({*names}) < 2 or len(names) not in values.shape:
        return {name: values}
    rows = values.T if len(values) >= values.shape[1] else values
    return (
        {f"{name}/{each}": row for each, row in zip(names, rows, strict=True)}
        if len(rows) == len(names)
        else {name: values}
    )


def _words(attributes: Mapping[str, Any], keys: tuple[str, ...]) -> list[str]:
    value = next((attributes[key] for key in keys if key in attributes), ())
    if isinstance(value, str) and "," in value:
        value = value.split(",")
    each = np.atleast_1d(np.asarray(value, dtype=object)).ravel()
    return [
        text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text).strip() for text in each
    ]
