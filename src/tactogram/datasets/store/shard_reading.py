"""Shard reader: metadata of recordings, and any slice of their samples."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from itertools import accumulate
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from tactogram.datasets.recording import RecordingInfo
from tactogram.datasets.store.layout import INFO_COLUMNS, StoredFile, StoreStreamInfo, axis_column, row_info
from tactogram.datasets.store.parquet import MissingFileError, open_parquet
from tactogram.datasets.store.remote import BlockReader, RemotePath
from tactogram.errors import DataError


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
        file = open_parquet(path, stored)
        self._streams = [name for name in streams if f"{name}_rate" in file.schema_arrow.names]
        table = file.read(
            columns=[f"{s}_{what}" for s in self._streams for what in ("rate", "axes", "length")]
        )
        self.rates = {s: table[f"{s}_rate"].to_numpy() for s in self._streams}
        self.lengths = {s: _filled(table[f"{s}_length"]) for s in self._streams}
        texts = {s: table[f"{s}_axes"].to_pylist() for s in self._streams}
        split = {
            text: tuple(text.split(",")) if text else () for column in texts.values() for text in set(column)
        }
        self.axes: dict[str, list[tuple[str, ...]]] = {s: [split[t] for t in texts[s]] for s in self._streams}
        self.places = self._first_bytes(file.metadata, streams)

    @cached_property
    def _metadata(self) -> tuple[list[RecordingInfo], list[str | None]]:
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

        `MissingFileError` if the file is gone, `DataError` if it is truncated.
        """
        place, path = int(self.places[column][row]) + 4 * start, self.path
        try:
            if isinstance(path, RemotePath):
                samples = np.frombuffer(self._blocks.read(path, place, 4 * (stop - start)), "<f4")
            else:
                samples = np.fromfile(path, "<f4", count=stop - start, offset=place)
        except FileNotFoundError as error:
            raise MissingFileError(f"{self.path}: not readable: {error}; import the data again") from error
        if len(samples) != stop - start:
            raise DataError(f"{self.path} is cut short; import the data again")
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
                place = np.zeros(len(held), np.int64)
                for group, (begin, end) in enumerate(zip([0, *ends], ends, strict=False)):
                    chunk = metadata.row_group(group).column(number)
                    after = np.cumsum(held[begin:end])
                    last = chunk.data_page_offset + chunk.total_compressed_size
                    place[begin:end] = last - 4 * (after[-1] - after + held[begin:end])
                places[column] = place
        return places


def _filled(column: pa.ChunkedArray) -> NDArray[np.int64]:
    return np.asarray(column.fill_null(0).to_numpy(), dtype=np.int64)
