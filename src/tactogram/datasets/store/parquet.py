"""Parquet files of a store, written as `layout` describes and checked when opened."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets.store.layout import StoredFile, file_hash, file_size
from tactogram.datasets.store.remote import RemotePath, readable
from tactogram.errors import DataError


class MissingFileError(DataError):
    """A file in ``dataset.json`` is missing: removed by hand, or replaced."""


def plain_parquet(path: Path, columns: pa.Schema) -> pq.ParquetWriter:
    """Return a writer whose column chunks are one plain page each."""
    return pq.ParquetWriter(
        path,
        columns,
        compression="none",
        use_dictionary=False,
        write_statistics=False,
        data_page_size=2**31 - 1,
    )


def close_quietly(file: pq.ParquetWriter | None) -> None:
    """Close a file that will be removed."""
    if file is not None:
        with suppress(OSError):  # a full disk fails again
            file.close()


def stored_file(path: Path, rows: int) -> StoredFile:
    """Return the entry in ``dataset.json`` of a written file of ``rows`` rows."""
    return StoredFile(path.name, rows, path.stat().st_size, file_hash(path))


def open_parquet(path: Path | RemotePath, stored: StoredFile) -> pq.ParquetFile:
    """Open ``path``; `MissingFileError` if it is gone, `DataError` if its size or rows differ from ``stored``."""
    try:
        size = file_size(path)
        if size != stored.bytes:
            raise DataError(f"{path}: must be {stored.bytes} bytes, got {size}; import the data again")
        file = pq.ParquetFile(readable(path), pre_buffer=isinstance(path, RemotePath))
    except FileNotFoundError as error:
        raise MissingFileError(f"{path}: not readable: {error}; import the data again") from error
    except (OSError, pa.ArrowException) as error:
        raise DataError(f"{path}: not readable: {error}; import the data again") from error
    if file.metadata.num_rows != stored.rows:
        raise DataError(
            f"{path}: must have {stored.rows} rows, got {file.metadata.num_rows}; import the data again"
        )
    return file
