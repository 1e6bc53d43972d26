"""Shard index: shard and row of each recording, by id."""

from __future__ import annotations

import io
from bisect import bisect_left
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate
from pathlib import Path

import numpy as np

from tactogram.datasets.store.layout import StoredFile, StoreInfo, store_hash
from tactogram.datasets.store.parquet import MissingFileError
from tactogram.datasets.store.remote import RemotePath
from tactogram.datasets.store.shard_reading import Shard
from tactogram.errors import DataError


@dataclass(frozen=True, eq=False)
class ShardIndex:
    """Shards, and the place of each recording in them.

    ``ids`` is an array of `tactogram.datasets.store.layout.ID_TABLE`, sorted by id; ``opened`` caches shards by number.
    """

    shards: tuple[StoredFile, ...]
    ids: np.ndarray
    opened: dict[int, Shard] = field(default_factory=dict)

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
        place = bisect_left(range(len(self.ids)), key, key=lambda i: self.ids["id"][i])
        return place if place < len(self.ids) and self.ids["id"][place] == key else None

    def find(self, id: str) -> tuple[int, int] | None:
        """Return shard and row of a recording, None if missing."""
        place = self.rank(id)
        return None if place is None else (int(self.ids["shard"][place]), int(self.ids["row"][place]))


def places_of(path: Path | RemotePath, facts: StoreInfo) -> ShardIndex:
    """Load the index of the store ``path``, memory-mapped; that of a remote one is read and compared with its hash.

    `MissingFileError` if the list of ids is gone; `DataError` if it is unreadable.
    """
    file = path / facts.ids
    try:
        if isinstance(file, RemotePath):
            ids = np.load(io.BytesIO(file.read_bytes()), allow_pickle=False)
            if store_hash(ids, facts.photographs, facts.ratings_sha256) != facts.sha256:
                raise DataError(
                    f"{file}: wrong hash: not the list of ids that was written; copy the store again"
                )
        else:
            ids = np.load(file, mmap_mode="r", allow_pickle=False)
    except FileNotFoundError as error:
        raise MissingFileError(f"{file}: not readable: {error}; import the data again") from error
    except (OSError, ValueError, KeyError) as error:
        raise DataError(f"{file}: not readable: {error}; import the data again") from error
    return ShardIndex(facts.shards, ids)
