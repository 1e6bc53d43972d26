"""Shards of a store: metadata and samples read, any slice of them, recordings written, and the index of ids."""

from __future__ import annotations

import io
import logging
import re
from bisect import bisect_left
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from tactogram.datasets.recording import Recording, RecordingInfo
from tactogram.datasets.store.layout import (
    ID_TABLE,
    INFO_COLUMNS,
    MissingFileError,
    StoredFile,
    StoreInfo,
    StoreStreamInfo,
    axis_column,
    close_quietly,
    facts_hash,
    info_row,
    open_parquet,
    plain_parquet,
    reading,
    row_info,
    schema,
    store_hash,
    stored_file,
)
from tactogram.datasets.store.pending import StagedFiles
from tactogram.datasets.store.remote import BlockReader, RemotePath
from tactogram.errors import DataError
from tactogram.signal import Signal

LOG = logging.getLogger("tactogram")
GROUP_BYTES, GROUP_ROWS = 2**25, 1024
"""Size of a row group, which the writer keeps in memory."""
SHARD_BYTES, SHARD_ROWS = 2**28, 16384
"""Size of a shard, which one damaged file costs."""
MOST_SAMPLES = 2**29 - 2**20
"""Samples per axis that fit into one Parquet page (2 GiB)."""
_NAME = re.compile(r"[A-Za-z0-9_+-]+")


class Shard:
    """Metadata of one shard's recordings, and the place of their samples in the file.

    ``streams`` are those of the store; a shard need not have all of them. ``blocks`` reads the
    samples of a remote file.

    Attributes
    ----------
    rates : dict of float64 array, shape (row,)
        Hz, or samples per mm, by stream; NaN where a recording lacks it.
    lengths : dict of int64 array, shape (row,)
        Samples per axis by stream; 0 where a recording lacks it.
    axes : dict of list of tuple of str
        Names by stream and row.
    places : dict of int64 array, shape (row,)
        Byte of the file at which the samples of each row begin, by axis column (`layout.axis_column`).
    """

    def __init__(
        self,
        path: Path | RemotePath,
        stored: StoredFile,
        streams: Mapping[str, StoreStreamInfo],
        blocks: BlockReader,
    ) -> None:
        self.path = path
        self._stored, self._blocks = stored, blocks
        with reading(path):
            file = open_parquet(path, stored)
            self._streams = [name for name in streams if f"{name}_rate" in file.schema_arrow.names]
            table = file.read(
                columns=[f"{s}_{what}" for s in self._streams for what in ("rate", "axes", "length")]
            )
            self.rates = {s: table[f"{s}_rate"].to_numpy() for s in self._streams}
            self.lengths = {s: _filled(table[f"{s}_length"]) for s in self._streams}
            self.axes: dict[str, list[tuple[str, ...]]] = {
                s: [tuple(text.split(",")) if text else () for text in table[f"{s}_axes"].to_pylist()]
                for s in self._streams
            }
            self.places = self._first_bytes(file.metadata, streams)

    @cached_property
    def _metadata(self) -> tuple[list[RecordingInfo], list[str | None]]:
        with reading(self.path):
            rows = open_parquet(self.path, self._stored).read(columns=list(INFO_COLUMNS)).to_pylist()
            return [row_info(row) for row in rows], [row["image"] for row in rows]

    @property
    def infos(self) -> list[RecordingInfo]:
        """Metadata by row."""
        return self._metadata[0]

    @property
    def images(self) -> list[str | None]:
        """Photograph keys by row."""
        return self._metadata[1]

    def has(self, stream: str, row: int) -> bool:
        """Return whether the recording in ``row`` has this stream."""
        return stream in self.lengths and bool(self.lengths[stream][row])

    def read(self, column: str, row: int, start: int, stop: int) -> NDArray[np.float32]:
        """Return samples ``start`` to ``stop`` of one row of an axis column (`layout.axis_column`), shape (time,).

        `MissingFileError` if the file is gone, `DataError` if it is damaged.
        """
        path = self.path
        with reading(path):
            if column not in self.places:
                raise DataError(f"lacks the column {column}")
            offset = int(self.places[column][row]) + 4 * start
            if not 0 <= offset <= offset + 4 * (stop - start) <= self._stored.bytes:
                raise DataError(f"{stop - start} samples cannot be at byte {offset}")
            if isinstance(path, RemotePath):
                samples = np.frombuffer(self._blocks.read(path, offset, 4 * (stop - start)), "<f4")
            else:
                samples = np.fromfile(path, "<f4", count=stop - start, offset=offset)
            if len(samples) != stop - start:
                raise DataError("cut short")
        return samples.astype(np.float32, copy=False)

    def _first_bytes(
        self, metadata: Any, streams: Mapping[str, StoreStreamInfo]
    ) -> dict[str, NDArray[np.int64]]:
        """Return for each axis column the byte at which the samples of each row begin.

        The values are at the end of the only page of a column chunk; see `layout`.
        """
        first = metadata.row_group(0)
        numbers = {first.column(i).path_in_schema: i for i in range(first.num_columns)}
        ends = list(accumulate(metadata.row_group(g).num_rows for g in range(metadata.num_row_groups)))
        places = {}
        for stream in self._streams:
            for axis in streams[stream].axes:
                column = axis_column(stream, axis)
                number = numbers.get(f"{column}.list.element")
                if number is None:
                    continue
                having = {axes for axes in set(self.axes[stream]) if axis in axes}
                held = np.array([axes in having for axes in self.axes[stream]]) * self.lengths[stream]
                first_bytes = np.zeros(len(held), np.int64)
                for group, (begin, end) in enumerate(zip([0, *ends], ends, strict=False)):
                    chunk = metadata.row_group(group).column(number)
                    after = np.cumsum(held[begin:end])
                    last = chunk.data_page_offset + chunk.total_compressed_size
                    first_bytes[begin:end] = last - 4 * (after[-1] - after + held[begin:end])
                places[column] = first_bytes
        return places


def _filled(column: pa.ChunkedArray) -> NDArray[np.int64]:
    return np.asarray(column.fill_null(0).to_numpy(), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class ShardIndex:
    """Shards, and the place of each recording in them.

    ``ids`` is an array of `tactogram.datasets.store.layout.ID_TABLE`, sorted by id; ``opened`` caches shards by number.
    """

    shards: tuple[StoredFile, ...]
    ids: np.ndarray
    opened: dict[int, Shard] = field(default_factory=dict)
    mended: bool = False
    """Whether ``ids`` were read from the shards, since their file is damaged."""

    def is_of(self, facts: StoreInfo) -> bool:
        """Return whether these are the ids and places of a whole store."""
        if self.ids.dtype != ID_TABLE or self.ids.shape != (facts.rows,):
            return False
        shard, row = self.ids["shard"], self.ids["row"]
        held = np.array([stored.rows for stored in facts.shards] or [0])
        inside = ((shard >= 0) & (shard < len(held)) & (row >= 0)).all() and (row < held[shard]).all()
        taken = len(np.unique(np.array(self.begins)[shard] + row)) if inside else -1
        return (
            taken == facts.rows
            and store_hash(self.ids, facts.photographs, facts.ratings_sha256) == facts.sha256
        )

    @cached_property
    def begins(self) -> list[int]:
        """Number of recordings before each shard, and in all."""
        return list(accumulate((shard.rows for shard in self.shards), initial=0))

    @cached_property
    def ends(self) -> list[int]:
        """Number of recordings up to the end of each shard."""
        return self.begins[1:]

    def rank(self, id: str) -> int | None:
        """Return the index of ``id`` in the sorted list, None if missing."""
        key = id.encode(errors="replace")
        rank = bisect_left(range(len(self.ids)), key, key=lambda i: self.ids["id"][i])
        return rank if rank < len(self.ids) and self.ids["id"][rank] == key else None

    def find(self, id: str) -> tuple[int, int] | None:
        """Return shard and row of a recording, None if missing."""
        rank = self.rank(id)
        return None if rank is None else (int(self.ids["shard"][rank]), int(self.ids["row"][rank]))


def places_of(path: Path | RemotePath, facts: StoreInfo) -> ShardIndex:
    """Load the index of the store ``path``, memory-mapped unless it is remote, and compare it with its hash.

    A damaged list of ids is made anew from the shards. `MissingFileError` if it is gone, `DataError` if the shards are
    damaged, too.
    """
    file = path / facts.ids
    try:
        with reading(file):
            if isinstance(file, RemotePath):
                ids = np.load(io.BytesIO(file.read_bytes()), allow_pickle=False)
            else:
                ids = np.load(file, mmap_mode="r", allow_pickle=False)
    except MissingFileError:
        raise
    except DataError:
        ids = np.zeros(0, ID_TABLE)
    index = ShardIndex(facts.shards, ids)
    if not index.is_of(facts):
        LOG.warning("%s: not the list of ids that was written; the shards are read instead", file)
        index = _read_again(path, facts)
    return index


def _read_again(path: Path | RemotePath, facts: StoreInfo) -> ShardIndex:
    """Return the index of what the shards hold."""
    rows = []
    for number, stored in enumerate(facts.shards):
        shard = Shard(path / stored.file, stored, facts.streams, BlockReader())
        for row, (info, image) in enumerate(zip(shard.infos, shard.images, strict=True)):
            rows.append((info.id.encode(), facts_hash(info, image), number, row))
    return ShardIndex(facts.shards, np.sort(np.array(rows, ID_TABLE), order="id"), mended=True)


class ShardWriter:
    """Writes recordings one by one, with few in memory; ``streams`` and ``shards`` are the stored ones."""

    def __init__(
        self, files: StagedFiles, streams: Mapping[str, StoreStreamInfo], shards: Iterable[StoredFile]
    ) -> None:
        self.streams: dict[str, StoreStreamInfo] = dict(streams)
        self.shards = list(shards)
        """Complete shards."""
        self._files = files
        self._path = files.folder
        self._file: pq.ParquetWriter | None = None
        self._rows: list[tuple[dict[str, Any], Mapping[str, Signal]]] = []
        self._bytes = self._shard_rows = self._shard_bytes = 0

    def widen(self, recording: Recording, where: str) -> None:
        """Add the streams and axes of ``recording``, of which new ones begin another shard; errors name ``where``."""
        widened = dict(self.streams)
        for name, signal in recording.streams.items():
            _check_names(where, name, signal)
            facts = widened.get(name) or StoreStreamInfo(signal.unit, signal.domain, ())
            widened[name] = facts.widened(name, signal, where)
        if widened != self.streams:
            schema(widened)
            self.close()
            self.streams = widened

    def add(self, recording: Recording, image: str | None) -> tuple[int, int]:
        """Take a recording after `widen`, and the key of its photograph; return its shard and row."""
        position = (len(self.shards), self._shard_rows)
        self._rows.append((info_row(recording, image), recording.streams))
        self._shard_rows += 1
        self._bytes += sum(signal.samples.nbytes for signal in recording.streams.values())
        if self._bytes >= GROUP_BYTES or len(self._rows) >= GROUP_ROWS:
            self._write_group()
        if self._shard_bytes >= SHARD_BYTES or self._shard_rows >= SHARD_ROWS:
            self.close()
        return position

    def close(self) -> None:
        """Complete the current shard, if there is one."""
        self._write_group()
        if self._file is not None:
            self._file.close()
            self.shards.append(stored_file(self._path, self._shard_rows))
        self._file = None
        self._shard_rows = self._shard_bytes = 0

    def abandon(self) -> None:
        """Close the current file; the caller removes it."""
        close_quietly(self._file)
        self._file = None

    def _write_group(self) -> None:
        if not self._rows:
            return
        if self._file is None:
            self._path = self._files.parquet("shard", len(self.shards))
            self._file = plain_parquet(self._path, schema(self.streams))
        columns = _columns([row for row, _ in self._rows], [s for _, s in self._rows], self.streams)
        table = pa.Table.from_arrays(columns, schema=self._file.schema)
        self._file.write_table(table, row_group_size=len(self._rows))
        self._rows.clear()
        self._shard_bytes += self._bytes
        self._bytes = 0


def _columns(
    rows: list[dict[str, Any]], recordings: list[Mapping[str, Signal]], streams: Mapping[str, StoreStreamInfo]
) -> list[pa.Array]:
    """Return the columns of one row group, in the order of `layout.schema`."""
    columns = [pa.array([row[name] for row in rows], kind) for name, kind in INFO_COLUMNS.items()]
    for name, facts in streams.items():
        signals = [recording.get(name) for recording in recordings]
        columns += [
            pa.array([s and s.rate for s in signals], pa.float64()),
            pa.array([s and ",".join(s.axes) for s in signals], pa.string()),
            pa.array([s and len(s) for s in signals], pa.int64()),
        ]
        for axis in facts.axes:
            parts = [s.axis(axis) if s is not None and axis in s.axes else None for s in signals]
            lengths = [0 if part is None else len(part) for part in parts]
            held = [part for part in parts if part is not None]
            values = held[0] if len(held) == 1 else np.concatenate([np.zeros(0, np.float32), *held])
            offsets = pa.array(np.concatenate([[0], np.cumsum(lengths)]), pa.int32())
            missing = pa.array([part is None for part in parts], pa.bool_())
            columns.append(pa.ListArray.from_arrays(offsets, pa.array(values), mask=missing))
    return columns


def _check_names(where: str, name: str, signal: Signal) -> None:
    for text in (name, *signal.axes):
        if not _NAME.fullmatch(text):
            raise DataError(where, f"names of streams and axes must be letters, digits, _+-; got {text!r}")
    if len(signal) > MOST_SAMPLES:
        raise DataError(
            where, f"{name} must be at most {MOST_SAMPLES} samples, got {len(signal)}; cut it first"
        )
