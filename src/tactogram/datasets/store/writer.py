"""Store writer: recordings, photographs and ratings become a store, atomically."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Self

import numpy as np

from tactogram.datasets.ratings.ratings import Ratings, write_ratings
from tactogram.datasets.recording import Recording, content_id, item_of
from tactogram.datasets.store.layout import (
    FACTS,
    ID_TABLE,
    StoredFile,
    StoreInfo,
    UnfinishedJob,
    check_utf8,
    facts_hash,
    store_hash,
    stored_file,
)
from tactogram.datasets.store.pending import StagedFiles, clear_unfinished
from tactogram.datasets.store.photographs import Photograph, PhotographWriter, image_key, photograph_of
from tactogram.datasets.store.remote import RemotePath, local
from tactogram.datasets.store.shards import ShardWriter
from tactogram.datasets.store.store import Store
from tactogram.errors import DataError
from tactogram.signal import Image
from tactogram.signal.io.atomic import atomic_write, to_disk, turn

KEPT_S = 60.0
"""Seconds between checkpoints: what a killed job does again."""


class StoreWriter:
    """Writes recordings one by one into shards, besides those of ``store``, whose content is ``facts``.

    Leaving its ``with`` block without `publish` or `finish` removes everything that was written, unless there is a
    checkpoint (`keep`) of ``job``. With ``durable`` the files survive a power cut
    (`tactogram.datasets.store.writing`).
    """

    def __init__(
        self,
        folder: Path | RemotePath,
        facts: StoreInfo,
        store: Store | None,
        *,
        durable: bool = False,
        job: str = "",
    ) -> None:
        folder = local(folder)
        self.folder, self.facts = folder, facts
        self.added = 0
        self.duplicates = list(facts.duplicates)
        self.skipped = list(facts.skipped)
        self.ratings: Ratings | None = None
        """Ratings to write; None keeps the stored ones."""
        self.photographs = {material: dict(sources) for material, sources in facts.photographs.items()}
        self.store_so_far = store
        """The store before this writer, or before the job was interrupted; None if there was none."""
        if store is not None:
            clear_unfinished(folder, own=False)
        self._files = StagedFiles(folder, adding=store is not None, durable=durable)
        self._shards = ShardWriter(self._files, facts.streams, facts.shards)
        pictures = () if store is None else store.photograph_keys()
        self._pictures = PhotographWriter(self._files, facts.images, pictures)
        self._ids: list[tuple[bytes, bytes, int, int]] = []
        self._items: set[str] = set()
        self._seen: dict[str, tuple[str | None, str]] = {}
        self._simulated = facts.simulated
        self._done = False
        self._job = job
        self.tasks_done = facts.unfinished.done if facts.unfinished else 0
        """Tasks of the job whose recordings are in the folder already."""
        self._kept_at = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, error: type[BaseException] | None, *_: object) -> None:
        self._shards.abandon()
        self._pictures.abandon()
        if not self._done and self.facts.unfinished is None:
            self._files.remove(but=self.facts.ids)
        if error is None or not self._done:  # otherwise earlier files may be left, which the notes name
            self._files.forget_notes()

    def add(self, recording: Recording, photograph: Photograph | None = None) -> bool:
        """Add one recording, with ``photograph`` if it has no image; return False if its samples are already stored.

        A `DataError` for a misfit: another unit, or the same samples with another material or item.
        """
        where = recording.source or recording.id
        if recording.id != content_id(recording.streams):
            raise DataError(where, f"id must follow from the samples, got {recording.id!r}; leave it empty")
        item = item_of(recording)
        earlier = self._earlier(recording.id)
        if earlier is not None:
            if earlier[0] != item:
                raise DataError(
                    where,
                    f"the same samples as {earlier[1]}, but called {item!r} here "
                    f"and {earlier[0]!r} there; leave one out",
                )
            self.duplicates.append({"id": recording.id, "kept": earlier[1], "dropped": where})
            return False
        facts_hash(recording, None)  # refuses what cannot be stored before anything is
        self._shards.widen(recording, where)
        key = self._add_image(recording, photograph)
        self._seen[recording.id] = (item, where)
        if item:
            self._items.add(item)
        self._simulated |= recording.simulated
        position = self._shards.add(recording, key)
        self._ids.append((recording.id.encode(), facts_hash(recording, key), *position))
        self.added += 1
        return True

    def add_photograph(self, photograph: Photograph | Image, material: str, *, source: str = "") -> bool:
        """Add a photograph of a material, of which there need be no recording; return False if it is already stored.

        ``source`` is its path relative to the imported folder. A `DataError` if the material has no name, or the same
        picture shows another one.
        """
        if not material:
            raise DataError(source or "a photograph", "must name the material it shows, got none")
        if isinstance(photograph, Image):
            photograph = photograph_of(photograph)
        check_utf8(source + material, source)
        key = photograph.key
        for other, sources in self.photographs.items():
            if key in sources and other != material:
                raise DataError(
                    source or key,
                    f"the same picture as {sources[key] or key}, but called {material!r} here and "
                    f"{other!r} there; leave one out",
                )
        if key in self.photographs.get(material, {}):
            return False
        self._pictures.add(photograph)
        self.photographs.setdefault(material, {})[key] = source
        self.added += 1
        return True

    @property
    def items(self) -> frozenset[str]:
        """Items that can be rated: all added ones and all stored ones."""
        stored = [] if self.store_so_far is None else [item_of(info) for info in self.store_so_far.index]
        return frozenset({*self._items, *self.photographs, *(item for item in stored if item)})

    def keep(self, done: int) -> None:
        """Make a checkpoint after ``done`` tasks of the job, unless the last one is younger than `KEPT_S`.

        The same job goes on after it (`tactogram.datasets.store.writing.new_store`), however this process ends.
        """
        if self._job and self.added and time.monotonic() - self._kept_at >= KEPT_S:
            self._save(UnfinishedJob(self._job, done))
            self._kept_at = time.monotonic()

    def finish(self) -> StoreInfo:
        """Close all files and write ``dataset.json``, which makes the folder a store.

        A `DataError` if there is nothing to write, an unknown item was rated, or the store was changed meanwhile.
        """
        facts = self._save(None)
        self._done = True
        return facts

    def _save(self, unfinished: UnfinishedJob | None) -> StoreInfo:
        self._shards.close()
        self._pictures.close()
        if not self._shards.shards and not self.photographs:
            raise DataError("no recordings and no photographs: nothing was written")
        rated, rated_hash = self.facts.ratings, self.facts.ratings_sha256
        if self.ratings is not None:
            rated, rated_hash = self._save_ratings(self.ratings), self.ratings.sha256
        ids = np.array(self._ids, ID_TABLE)
        if self.store_so_far is not None:
            ids = np.concatenate([self.store_so_far._ids, ids])
        ids.sort(order="id")
        sha256 = store_hash(ids, self.photographs, rated_hash)
        ids_file = f"ids-{sha256[:16]}.npy"
        facts = replace(
            self.facts,
            simulated=self._simulated,
            sha256=sha256,
            streams=self._shards.streams,
            shards=tuple(self._shards.shards),
            images=tuple(self._pictures.images),
            ids=ids_file,
            duplicates=tuple(self.duplicates),
            skipped=tuple(self.skipped),
            photographs=self.photographs,
            ratings=rated,
            ratings_sha256=rated_hash,
            unfinished=unfinished,
        )
        with turn(self.folder):
            if self.store_so_far is not None and StoreInfo.load(self.folder) != self.facts:
                raise DataError(f"{self.folder} was changed by another process; open it again and repeat")
            self._save_ids(ids, self.folder / ids_file)
            with atomic_write(self.folder / FACTS) as part:
                self._files.begin(part)
                part.write_text(facts.text(), encoding="utf-8")
                self._files.to_disk()
            # From here on the store names the new files, and they stay even if what follows fails.
            earlier, self.facts, self._done = self.facts, facts, self.store_so_far is not None
            if self._files.durable:
                to_disk(self.folder)
        old = {earlier.ids, earlier.ratings.file if earlier.ratings else ""}
        new = {ids_file, rated.file if rated else ""}
        for name in old - new - {""}:
            with suppress(OSError):  # such as of a folder in its place
                (self.folder / name).unlink()
        return facts

    def publish(self, path: Path) -> StoreInfo:
        """Finish and rename the folder to ``path``; `DataError` if that fails."""
        facts = self.finish()
        self._done = False
        self._files.forget_notes()
        try:
            self.folder.rename(path)
        except OSError as error:
            raise DataError(f"{path} cannot be made: {error.strerror}") from error
        if self._files.durable:
            to_disk(path.parent)
        self._done = True
        return facts

    def _earlier(self, id: str) -> tuple[str | None, str] | None:
        """Return item and source of a recording that is already stored or added."""
        if id in self._seen:
            return self._seen[id]
        if self.store_so_far is not None and id in self.store_so_far:
            info = self.store_so_far.info(id)
            return item_of(info), info.source or id
        return None

    def _save_ids(self, ids: np.ndarray, path: Path) -> None:
        with atomic_write(path) as part:
            self._files.begin(path)
            # The current list, too: it is removed last, and a kill may come before that.
            self._files.note(self.folder / self.facts.ids)
            np.save(part, ids, allow_pickle=False)

    def _save_ratings(self, ratings: Ratings) -> StoredFile:
        """Write ratings to a new file, so that the old ones remain until ``dataset.json`` is replaced."""
        known = self.items
        if unknown := [item for item in ratings.items if item not in known]:
            raise DataError(
                f"ratings must be of items in the store, got {', '.join(unknown[:5])}"
                f"{' …' if len(unknown) > 5 else ''}; an item is a recording's label item, else its material, or the "
                "material of a photograph; without=A,B leaves items out"
            )
        path = self._files.parquet("ratings", 0)
        write_ratings(path, ratings)
        return stored_file(path, len(ratings))

    def _add_image(self, recording: Recording, photograph: Photograph | None) -> str | None:
        if recording.image is not None:
            key = image_key(recording.image)
            if key in self._pictures.keys:
                return key
            photograph = photograph_of(recording.image)
        if photograph is None:
            return None
        self._pictures.add(photograph)
        return photograph.key
