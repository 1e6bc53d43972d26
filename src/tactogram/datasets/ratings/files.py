"""Rating files: Parquet with scale and words inside."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets.parquet_table import read_parquet
from tactogram.datasets.ratings.ratings import COLUMNS, Ratings, Scale
from tactogram.errors import DataError
from tactogram.signal.io.atomic import atomic_write


def write_ratings(path: Path, ratings: Ratings) -> None:
    """Write a Parquet file; the whole file or nothing."""
    about = {"scale": asdict(ratings.scale), "words": list(ratings.words)}
    table = pa.table({name: pa.array(getattr(ratings, name)) for name in COLUMNS})
    with atomic_write(path) as part:
        pq.write_table(table.replace_schema_metadata({"tactogram": json.dumps(about)}), part)


def read_ratings(file: Path | pa.NativeFile, *, name: str = "") -> Ratings:
    """Read a file of `write_ratings`; `DataError`, which gives its ``name``, if it is something else."""
    try:
        table = read_parquet(file, name)
        about = json.loads((table.schema.metadata or {})[b"tactogram"])
        columns = {name: table[name].to_pylist() for name in COLUMNS}
        return Ratings(**columns, scale=Scale(**about["scale"]), words=tuple(about["words"]))
    except (KeyError, TypeError, ValueError, DataError) as error:
        raise DataError(f"{name or file}: not a table of ratings: {error}") from error
