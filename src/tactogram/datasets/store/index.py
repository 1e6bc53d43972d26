"""Shard index: shard and row of each recording, by id."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import accumulate
from pathlib import Path

import numpy as np

from tactogram.datasets.store.layout import StoredFile, StoreInfo
from tactogram.datasets.store.parquet import MissingFileError
from tactogram.datasets.store.shard_reading import Shard
from tactogram.errors import DataError


@dataclass(frozen=True, eq=False)
class ShardIndex:
    """Shards, and where in them each recording is; exchanged as a whole, so that no thread mixes two.

    Parameters
    ----------
    shards : tuple of StoredFile
    ids : array of `tactogram.datasets.store.layout.ID_TABLE`, sorted by id
    opened : dict
        Shards that were read already, by number.
    """

    shards: tuple[StoredFile, ...]
    ids: np.ndarray
    opened: dict[int, Shard] = field(default_factory=dict)

    @cached_property
    def begins(self) -> list[int]:
        """How many recordings stand before each shard, and before the end."""
        return list(accumulate((shard.rows for shard in self.shards), initial=0))

    @cached_property
    def ends(self) -> list[int]:
        """How many recordings stand before the end of each shard."""
        return self.begins[1:]

    def rank(self, id: str) -> int | None:
        """Return where ``id`` stands in the sorted list, None if it does not."""
        key = id.encode(errors="replace")
        place = bisect_left(range(len(self.ids)), key, key=lambda i: self.ids["id"][i])
        return place if place < len(self.ids) and self.ids["id"][place] == key else None

    def find(self, id: str) -> tuple[int, int] | None:
        """Return shard and row of a recording, None if there is none of this id."""
        place = self.rank(id)
        return None if place is None else (int(self.ids["shard"][place]), int(self.ids["row"][place]))

    def first(self, count: int) -> ShardIndex:
        """Return the places of the first ``count`` recordings alone, in the order in which they were put in."""
        order = np.array(self.begins)[self.ids["shard"]] + self.ids["row"]
        return self if count >= self.begins[-1] else replace(self, ids=self.ids[order < count])


def places_of(path: Path, facts: StoreInfo) -> ShardIndex:
    """Read where the recordings of the store ``path`` stand; memory-mapped.

    Raises
    ------
    GoneError
        If the list of ids is not there.
    DataError
        If it cannot be read.
    """
    try:
        ids = np.load(path / facts.ids, mmap_mode="r", allow_pickle=False)
    except FileNotFoundError as error:
        raise MissingFileError(f"{path / facts.ids}: not readable: {error}; import the data again") from error
    except (OSError, ValueError) as error:
        raise DataError(f"{path / facts.ids}: not readable: {error}; import the data again") from error
    return ShardIndex(facts.shards, ids)
