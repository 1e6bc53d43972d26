"""Catalogue of a store: metadata of all recordings and the places of their samples, in a file apart from the shards.

``catalogue-*.parquet`` has a row group per shard of the store, in that order, and a row per recording: the columns of a
shard without its samples, and ``acceleration_x_begin``: the byte of the shard at which the samples of the recording
begin. A store with a catalogue is opened, searched and split without its shards, and a window of an axis is read as one
range of bytes. Stores get one when they are copied (`copying`); adding recordings drops it.
"""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets.store.layout import INFO_COLUMNS, StoredFile, StoreInfo, axis_column
from tactogram.datasets.store.parquet import open_parquet
from tactogram.datasets.store.remote import RemotePath
from tactogram.datasets.store.shard_reading import Shard


class Catalogue:
    """Reader of a catalogue; of each shard's part on first use."""

    def __init__(self, path: Path | RemotePath, stored: StoredFile) -> None:
        self._file = open_parquet(path, stored)

    def table(self, shard: int) -> pa.Table:
        """Return the rows of a shard."""
        return self._file.read_row_group(shard)


def write_catalogue(path: Path, folder: Path | RemotePath, facts: StoreInfo) -> None:
    """Write the catalogue of the store in ``folder``; reads the metadata of its shards."""
    columns = list(INFO_COLUMNS.items())
    for name, stream in facts.streams.items():
        columns += [
            (f"{name}_rate", pa.float64()),
            (f"{name}_axes", pa.string()),
            (f"{name}_length", pa.int64()),
        ]
        columns += [(begin_column(axis_column(name, axis)), pa.int64()) for axis in stream.axes]
    schema = pa.schema(columns)
    with pq.ParquetWriter(path, schema, compression="zstd") as file:
        for stored in facts.shards:
            shard = Shard(folder / stored.file, stored, facts.streams)
            held = shard.metadata_table()
            arrays = []
            for column, kind in zip(schema.names, schema.types, strict=True):
                if column in held.column_names:
                    arrays.append(held[column].combine_chunks().cast(kind))
                else:
                    places = shard.places.get(column.removesuffix("_begin"))
                    none = pa.nulls(stored.rows, kind)
                    arrays.append(none if places is None else pa.array(places, kind))
            file.write_table(pa.Table.from_arrays(arrays, schema=schema), row_group_size=max(1, stored.rows))


def begin_column(column: str) -> str:
    """Return the name of the column with the first bytes of an axis column's samples."""
    return f"{column}_begin"
