"""One Parquet file of a store: written as `layout` says, and read only if it is as it was written."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets.store.layout import StoredFile, file_hash
from tactogram.errors import DataError


class MissingFileError(DataError):
    """A file that ``dataset.json`` named is not there: removed by hand, or written anew (`compacting`)."""


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
        # On a full disk this fails once more.
        with suppress(OSError):
            file.close()


def stored_file(path: Path, rows: int) -> StoredFile:
    """Return what ``dataset.json`` says of a file that was written, of ``rows`` rows."""
    return StoredFile(path.name, rows, path.stat().st_size, file_hash(path))


def opened(path: Path, stored: StoredFile) -> pq.ParquetFile:
    """Open ``path``.

    Raises
    ------
    GoneError
        If it is not there.
    DataError
        If it is not as long as ``stored`` says, in bytes or rows, or not Parquet.
    """
    try:
        size = path.stat().st_size
        if size != stored.bytes:
            raise DataError(f"{path}: must be {stored.bytes} bytes, got {size}; import the data again")
        file = pq.ParquetFile(path)
    except FileNotFoundError as error:
        raise MissingFileError(f"{path}: not readable: {error}; import the data again") from error
    except (OSError, pa.ArrowException) as error:
        raise DataError(f"{path}: not readable: {error}; import the data again") from error
    if file.metadata.num_rows != stored.rows:
        raise DataError(
            f"{path}: must have {stored.rows} rows, got {file.metadata.num_rows}; import the data again"
        )
    return file
