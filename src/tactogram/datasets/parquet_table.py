"""Foreign Parquet tables, whose size is checked before they are read."""

from __future__ import annotations

from pathlib import Path
from typing import BinaryIO

import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.errors import DataError

MIB = 2**20
MOST_ROWS = 2_000_000
MOST_BYTES = 256 * MIB


def check_parquet(source: Path | BinaryIO | pa.NativeFile, where: Path | str) -> None:
    """Raise a `DataError` if it is not Parquet, or unpacks to more than `MOST_ROWS` rows or `MOST_BYTES` bytes."""
    try:
        facts = pq.read_metadata(source)
        unpacked = sum(facts.row_group(i).total_byte_size for i in range(facts.num_row_groups))
    except (OSError, ValueError, pa.ArrowException) as error:
        raise DataError(f"{where}: not a readable Parquet file: {error}") from error
    if facts.num_rows > MOST_ROWS or unpacked > MOST_BYTES:
        raise DataError(
            f"{where}: must have at most {MOST_ROWS} rows and {MOST_BYTES // MIB} MiB, "
            f"got {facts.num_rows} and {unpacked / MIB:.0f} MiB"
        )


def read_parquet(source: Path | pa.NativeFile, name: str = "") -> pa.Table:
    """Return a table, from a path or from a file of this ``name``; errors as `check_parquet`."""
    where = name or source
    check_parquet(source, where)
    try:
        return pq.read_table(source)
    except (OSError, ValueError, pa.ArrowException) as error:
        raise DataError(f"{where}: not a readable Parquet file: {error}") from error
