"""Comparison of imported files with an existing store."""

from __future__ import annotations

from pathlib import Path
from typing import Self

from tactogram.datasets.ratings.ratings import Ratings, item_of
from tactogram.datasets.recording import Recording
from tactogram.datasets.store.photographs import Photograph
from tactogram.datasets.store.store import Store
from tactogram.errors import DataError


class StoreMismatchError(DataError):
    """The files differ from what the store holds."""


class StoreComparison:
    """Compares recordings with an existing store; used like a `StoreWriter`."""

    def __init__(self, store: Store, path: Path) -> None:
        self.store, self.path = store, path
        self.duplicates: list[dict[str, str]] = []
        self.skipped: list[dict[str, str]] = []
        self.ratings: Ratings | None = None
        self.items: set[str] = set()
        self.tasks_done = 0
        self._recordings: dict[str, str] = {}
        self._photographs: set[tuple[str, str]] = set()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def add(self, recording: Recording, photograph: Photograph | None = None) -> None:
        """Compare a recording; an error if the store does not hold it."""
        where = recording.source or recording.id
        if earlier := self._recordings.get(recording.id):
            self.duplicates.append({"id": recording.id, "kept": earlier, "dropped": where})
            return
        if not self.store.holds(recording, photograph):
            raise self._mismatch(f"{where} is another or new")
        self._recordings[recording.id] = where
        if item := item_of(recording):
            self.items.add(item)

    def add_photograph(self, photograph: Photograph, material: str, *, source: str = "") -> None:
        """Compare a photograph of a material."""
        self._photographs.add((material, photograph.key))
        if photograph.key not in self.store.facts.photographs.get(material, {}):
            raise self._mismatch(f"{source} is another or new")
        self.items.add(material)

    def keep(self, done: int) -> None:
        """Do nothing: there is nothing to write."""

    def finish(self) -> None:
        """Raise an error if the store holds more."""
        stored = sum(len(sources) for sources in self.store.facts.photographs.values())
        if len(self._photographs) != stored:
            raise self._mismatch(f"{len(self._photographs)} photographs of materials here, {stored} there")
        if len(self._recordings) != len(self.store):
            raise self._mismatch(f"{len(self._recordings)} recordings here, {len(self.store)} there")
        # Ratings that were added to the store of a set without any are no mismatch.
        if self.ratings is not None and self.ratings.sha256 != self.store.facts.ratings_sha256:
            raise self._mismatch("its ratings differ")

    def _mismatch(self, how: str) -> StoreMismatchError:
        return StoreMismatchError(
            f"{self.store.path} exists and holds something else than {self.path} ({how}); "
            "remove it or choose another out"
        )
