"""Shard writer: rows of recordings, a row group at a time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets.recording import Recording
from tactogram.datasets.store.layout import INFO_COLUMNS, StoredFile, StoreStreamInfo, info_row, schema
from tactogram.datasets.store.parquet import close_quietly, plain_parquet, stored_file
from tactogram.datasets.store.pending import StagedFiles
from tactogram.errors import DataError
from tactogram.signal import Signal

GROUP_BYTES, GROUP_ROWS = 2**25, 1024
"""Size of a row group, which the writer keeps in memory."""
SHARD_BYTES, SHARD_ROWS = 2**28, 16384
"""Size of a shard, which one damaged file costs."""
MOST_SAMPLES = 2**29 - 2**20
"""Samples per axis that fit into one Parquet page (2 GiB)."""

_NAME = re.compile(r"[A-Za-z0-9_+-]+")


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
        place = (len(self.shards), self._shard_rows)
        self._rows.append((info_row(recording, image), recording.streams))
        self._shard_rows += 1
        self._bytes += sum(signal.samples.nbytes for signal in recording.streams.values())
        if self._bytes >= GROUP_BYTES or len(self._rows) >= GROUP_ROWS:
            self._write_group()
        if self._shard_bytes >= SHARD_BYTES or self._shard_rows >= SHARD_ROWS:
            self.close()
        return place

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
            values = np.concatenate([np.zeros(0, np.float32), *(p for p in parts if p is not None)])
            offsets = pa.array(np.concatenate([[0], np.cumsum(lengths)]), pa.int32())
            missing = pa.array([part is None for part in parts], pa.bool_())
            columns.append(pa.ListArray.from_arrays(offsets, pa.array(values), mask=missing))
    return columns


def _check_names(where: str, name: str, signal: Signal) -> None:
    for text in (name, *signal.axes):
        if not _NAME.fullmatch(text):
            raise DataError(f"{where}: names of streams and axes must be letters, digits, _+-; got {text!r}")
    if len(signal) > MOST_SAMPLES:
        raise DataError(
            f"{where}: {name} must be at most {MOST_SAMPLES} samples, got {len(signal)}; cut it first"
        )
