"""Parquet, Feather and JSON: columns read by pyarrow, and records as web services and loggers write them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import DataError
from tactogram.signal.io.archives import check_size, decoding
from tactogram.signal.io.arrays import array_tables
from tactogram.signal.io.content import Column, RawTable
from tactogram.signal.io.table_columns import converted
from tactogram.text_files import detected_text, parse_json


def tables(path: Path) -> list[RawTable]:
    """Return the table in a Parquet, Feather or Arrow file, with the units in the metadata of its fields."""
    import pyarrow.feather as feather
    import pyarrow.parquet as parquet

    with decoding(path, "truncated or not a table"):
        if path.suffix.lower() == ".parquet":
            meta = parquet.read_metadata(path)
            size = sum(meta.row_group(i).total_byte_size for i in range(meta.num_row_groups))
            check_size(size, path)
            table = parquet.read_table(path)
        else:
            table = feather.read_table(path)
            check_size(table.nbytes, path)
        table = table.flatten()  # fields of structures as columns
        names = tuple(table.column_names)
        units = tuple(_unit(field.metadata or {}) for field in table.schema)
        columns = tuple(_column(table.column(i)) for i in range(table.num_columns))
    return [RawTable(path, names, columns, units=units if any(units) else ())]


def json_tables(path: Path) -> list[RawTable]:
    """Return the records in a JSON file: one object per line, a list of objects, or lists by name."""
    text, _ = detected_text(path.read_bytes(), path)
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise DataError(path, "empty file")
    if len(lines) > 1 and all(line.strip().endswith("}") for line in lines[:20]):
        content: Any = parse_json(f"[{','.join(lines)}]", path)
    else:
        content = parse_json(text, path)
    if isinstance(content, dict):
        lists = {
            name: np.asarray(each) for name, each in content.items() if isinstance(each, list | int | float)
        }
        return array_tables(path, {name: each for name, each in lists.items() if each.dtype.kind in "fiub"})
    if not isinstance(content, list) or not all(isinstance(row, dict) for row in content):
        raise DataError(path, "must hold objects of names and numbers, one per sample")
    rows = [_flat(row) for row in content]
    names = list(dict.fromkeys(name for row in rows for name in row))
    return [RawTable(path, tuple(names), tuple(converted([row.get(name) for row in rows]) for name in names))]


def _flat(row: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return an object with the names of inner ones as ``outer.inner``, lists of numbers as ``outer.1`` …."""
    flat: dict[str, Any] = {}
    for name, value in row.items():
        inner = {str(i): each for i, each in enumerate(value, 1)} if isinstance(value, list) else value
        flat |= _flat(inner, f"{prefix}{name}.") if isinstance(inner, dict) else {f"{prefix}{name}": inner}
    return flat


def _column(values: Any) -> Column:
    array = values.to_numpy()
    if array.dtype.kind in "fiub":
        return np.asarray(array, dtype=np.float64)
    if array.dtype.kind == "m":
        return np.asarray(array / np.timedelta64(1, "s"), dtype=np.float64)
    if array.dtype.kind == "M":
        stamps = np.empty(len(array), dtype=object)
        stamps[:] = [None if np.isnat(each) else str(each) for each in array]
        return stamps
    return converted(array.tolist())


def _unit(metadata: dict[bytes, bytes]) -> str | None:
    known = {
        key.decode("utf-8", "replace").lower(): value.decode("utf-8", "replace")
        for key, value in metadata.items()
    }
    return known.get("unit") or known.get("units")
