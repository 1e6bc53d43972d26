"""Writing a store: in one pass, in flat memory, complete or not at all."""

from __future__ import annotations

import os
import re
import shutil
import socket
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import psutil
import pyarrow as pa
import pyarrow.parquet as pq

from tactogram.datasets.layout import (
    FACTS,
    ID_TABLE,
    INFO_COLUMNS,
    Facts,
    StoredFile,
    StreamFacts,
    facts_hash,
    file_hash,
    info_row,
    schema,
    store_hash,
)
from tactogram.datasets.photographs import Photograph, image_key, photograph_of
from tactogram.datasets.ratings import Ratings, item_of
from tactogram.datasets.ratings_io import write_ratings
from tactogram.datasets.recording import Recording, content_id
from tactogram.datasets.store import Store, open_store
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal

GROUP_BYTES, GROUP_ROWS = 2**25, 1024
"""A row group is written when it holds this much: what the writer keeps in memory."""
SHARD_BYTES, SHARD_ROWS = 2**28, 16384
"""A shard is closed when it holds this much: what one damaged file costs."""
MOST_SAMPLES = 2**29 - 2**20
"""Samples per axis that fit into one Parquet page (2 GiB)."""

_NAME = re.compile(r"[A-Za-z0-9_+-]+")


def create_store(
    path: Path | str,
    recordings: Iterable[Recording],
    *,
    name: str,
    licence: str,
    source: str = "",
    simulated: bool = False,
    photographs: Iterable[tuple[str, Image]] = (),
    ratings: Ratings | None = None,
) -> Store:
    """Write ``recordings`` to a new store and open it. It appears complete, or not at all.

    Parameters
    ----------
    path : Path
        A folder that does not exist yet.
    recordings : iterable of Recording
        Read once; a few at a time are in memory. Equal samples are one recording: ``facts.duplicates`` lists
        what was left out.
    name, licence, source : str
        What it is called, what may be done with it, where it comes from.
    simulated : bool
        Whether a formula made it; also true if any recording says so.
    photographs : iterable of (str, Image)
        Materials and what they look like, besides the recordings' own images; any number of each.
    ratings : Ratings, optional
        What people said of items (`item_of`).

    Raises
    ------
    DataError
        If ``path`` exists, there are neither recordings nor photographs, one cannot stand beside the others, or
        something was rated that is not there.
    """
    path = Path(path)
    if path.exists():
        raise DataError(f"{path} must not exist yet; choose another folder, or data add to it")
    with new_store(path, name=name, licence=licence, source=source, simulated=simulated) as writer:
        for recording in recordings:
            writer.add(recording)
        for material, image in photographs:
            writer.add_photograph(image, material)
        writer.ratings = ratings
        writer.publish(path)
    return open_store(path)


def add_recordings(
    store: Store,
    recordings: Iterable[Recording],
    *,
    photographs: Iterable[tuple[str, Image]] = (),
    durable: bool = False,
) -> Store:
    """Put further recordings, and photographs of materials, into ``store`` and open it anew.

    They go to new shards; ``dataset.json`` is replaced last and at once. What is there already is left out.
    ``durable`` waits until all of it is on the disk, so that not even a power cut loses it.

    Raises
    ------
    DataError
        If a recording cannot stand beside the others, or the store was changed meanwhile.
    """
    with StoreWriter(store.path, store.facts, store) as writer:
        writer.durable = durable
        for recording in recordings:
            writer.add(recording)
        for material, image in photographs:
            writer.add_photograph(image, material)
        if writer.added:
            writer.finish()
    return open_store(store.path)


def add_ratings(store: Store, ratings: Ratings, *, replace: bool = False) -> Store:
    """Put ``ratings`` of its items into ``store`` and open it anew; ``dataset.json`` is replaced last and at once.

    Parameters
    ----------
    store : Store
    ratings : Ratings
    replace : bool
        Whether those that are there already may go.

    Raises
    ------
    DataError
        If there are ratings already and ``replace`` was not said, something was rated that is not in the store, or
        the store was changed meanwhile.
    """
    there = store.facts.ratings
    if there is not None and not replace:
        raise DataError(
            f"{store.path} has ratings already ({there.rows} scores); --replace puts these in their place"
        )
    with StoreWriter(store.path, store.facts, store) as writer:
        writer.ratings = ratings
        writer.finish()
    return open_store(store.path)


def new_store(path: Path, *, name: str, licence: str, source: str, simulated: bool) -> StoreWriter:
    """Return a writer into a part folder beside ``path``."""
    if not name:
        raise ParameterError("a store needs a name, got ''")
    if not licence:
        raise ParameterError("a store needs a licence; say 'not stated' where the source states none")
    part = path.with_name(f"{path.name}.part-{_host()}-{os.getpid()}")
    if part.exists():
        shutil.rmtree(part)
    part.mkdir(parents=True)
    empty = Facts(name, licence, source, simulated, "", {}, (), (), "")
    return StoreWriter(part, empty, None)


def clear_stale_parts(path: Path) -> list[Path]:
    """Remove part folders of ``path`` whose process is gone; return those of which that is not known."""
    left = []
    for part in sorted(path.parent.glob(f"{path.name}.part-*")):
        host, _, process = part.name.removeprefix(f"{path.name}.part-").rpartition("-")
        if host == _host() and process.isdigit() and not psutil.pid_exists(int(process)):
            shutil.rmtree(part, ignore_errors=True)
        elif not (host == _host() and process == str(os.getpid())):
            left.append(part)
    return left


def clear_unfinished(path: Path) -> list[str]:
    """Remove what a killed process left in the store ``path`` on its way into it, and return the files' names.

    Only what was noted before it was written, and what ``dataset.json`` does not name: a reader of all
    ``shard-*.parquet`` then finds what the store holds. Those of a process that still runs are left alone.
    """
    removed = []
    for noted in sorted(path.glob(f"adding-{_host()}-*.txt")):
        process = noted.stem.rpartition("-")[2]
        if process.isdigit() and int(process) != os.getpid() and psutil.pid_exists(int(process)):
            continue
        facts = Facts.load(path)
        named = {stored.file for stored in (*facts.shards, *facts.images)} | {facts.ids, FACTS}
        named |= {facts.ratings.file} if facts.ratings is not None else set()
        for name in noted.read_text(encoding="utf-8").split():
            if name not in named and (path / name).exists():
                (path / name).unlink()
                removed.append(name)
        noted.unlink()
    return removed


def to_disk(*paths: Path) -> None:
    """Return when files and folders are on the disk itself (fsync): a pulled plug takes nothing of them."""
    for path in paths:
        if os.name == "nt" and path.is_dir():  # cannot be opened there; the file system sees to it
            continue
        opened = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


class StoreWriter:
    """Takes recordings one by one and writes shards.

    Leaving its ``with`` block without `publish` or `finish` removes all that was written.

    Parameters
    ----------
    folder : Path
        Where the files go.
    facts : Facts
        What is there already.
    store : Store or None
        The store that ``facts`` are of; None for a new one.
    """

    def __init__(self, folder: Path, facts: Facts, store: Store | None) -> None:
        self.folder, self.facts = folder, facts
        self.durable = False
        """Whether what is written shall outlast a pulled plug (`tactogram.datasets.appending`)."""
        self._noted = folder / f"adding-{_host()}-{os.getpid()}.txt"
        self.added = 0
        self.streams: dict[str, StreamFacts] = dict(facts.streams)
        self.duplicates = list(facts.duplicates)
        self.skipped = list(facts.skipped)
        self.ratings: Ratings | None = None
        """To be written with the rest; None leaves those that are there."""
        self.photographs = {material: dict(held) for material, held in facts.photographs.items()}
        self._store = store
        self._ids: list[tuple[bytes, bytes, int, int]] = []
        self._items: set[str] = set()
        self._seen: dict[str, tuple[str | None, str]] = {}
        self._rows: list[tuple[dict[str, Any], Mapping[str, Signal]]] = []
        self._bytes = self._shard_rows = self._shard_bytes = 0
        self._shards = list(facts.shards)
        self._images = list(facts.images)
        self._pictures = set() if store is None else set(store.photograph_keys())
        self._new_pictures = 0
        self._picture_path = folder
        self._shard: pq.ParquetWriter | None = None
        self._image_file: pq.ParquetWriter | None = None
        self._simulated = facts.simulated
        self._written: list[Path] = []
        self._done = False

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Remove what was written, unless it was finished."""
        for writer in (self._shard, self._image_file):
            if writer is not None:
                # On a full disk this fails once more; what is there is removed below.
                with suppress(OSError):
                    writer.close()
        self._shard = self._image_file = None
        if not self._done:
            if self._store is None:
                shutil.rmtree(self.folder, ignore_errors=True)
            for path in self._written:
                path.unlink(missing_ok=True)
        self._noted.unlink(missing_ok=True)

    def add(self, recording: Recording, photograph: Photograph | None = None) -> bool:
        """Take one recording; False if its samples were there already.

        Parameters
        ----------
        recording : Recording
        photograph : Photograph, optional
            Stands for ``recording.image`` where that is None.

        Raises
        ------
        DataError
            If it cannot stand beside the others: another unit, or the same samples of another material or item.
        """
        where = recording.source or recording.id
        if recording.id != content_id(recording.streams):
            raise DataError(f"{where}: id must follow from the samples, got {recording.id!r}; leave it empty")
        kept = self._met(recording.id)
        if kept is not None:
            if kept[0] != item_of(recording):
                raise DataError(
                    f"{where}: the same samples as {kept[1]}, but called {item_of(recording)!r} here "
                    f"and {kept[0]!r} there; leave one out"
                )
            self.duplicates.append({"id": recording.id, "kept": kept[1], "dropped": where})
            return False
        widened = dict(self.streams)
        for name, signal in recording.streams.items():
            _check_names(where, name, signal)
            facts = widened.get(name) or StreamFacts(signal.unit, signal.domain, ())
            widened[name] = facts.widened(name, signal, where)
        if widened != self.streams:
            schema(widened)
            self._close_shard()
            self.streams = widened
        key = self._keep_picture(recording, photograph)
        self._seen[recording.id] = (item_of(recording), where)
        if item := item_of(recording):
            self._items.add(item)
        self._simulated |= recording.simulated
        place = (len(self._shards), self._shard_rows)
        self._ids.append((recording.id.encode(), facts_hash(recording, key), *place))
        self._rows.append((info_row(recording, key), recording.streams))
        self._shard_rows += 1
        self._bytes += sum(signal.samples.nbytes for signal in recording.streams.values())
        self.added += 1
        if self._bytes >= GROUP_BYTES or len(self._rows) >= GROUP_ROWS:
            self._write_group()
        if self._shard_bytes >= SHARD_BYTES or self._shard_rows >= SHARD_ROWS:
            self._close_shard()
        return True

    def add_photograph(self, photograph: Photograph | Image, material: str, *, source: str = "") -> bool:
        """Take a photograph of a material that is not of one recording; False if it was there already.

        Parameters
        ----------
        photograph : Photograph or Image
        material : str
            What it shows. There need be no recording of it.
        source : str
            Where it came from, as a path relative to the imported folder.

        Raises
        ------
        DataError
            If the material has no name, or the same picture is said to show another one.
        """
        if not material:
            raise DataError(f"{source or 'a photograph'}: must name the material it shows, got none")
        if isinstance(photograph, Image):
            photograph = photograph_of(photograph)
        key = photograph.key
        for other, held in self.photographs.items():
            if key in held and other != material:
                raise DataError(
                    f"{source or key}: the same picture as {held[key] or key}, but called {material!r} here and "
                    f"{other!r} there; leave one out"
                )
        if key in self.photographs.get(material, {}):
            return False
        self._write_picture(photograph)
        self.photographs.setdefault(material, {})[key] = source
        self.added += 1
        return True

    @property
    def items(self) -> frozenset[str]:
        """What may be rated: all that was taken, and all that was there."""
        there = [] if self._store is None else [item_of(info) for info in self._store.index]
        return frozenset({*self._items, *self.photographs, *(item for item in there if item)})

    def finish(self) -> Facts:
        """Close all files and write ``dataset.json``, which makes the folder a store."""
        self._close_shard()
        if self._image_file is not None:
            self._image_file.close()
            self._images.append(_stored(self._picture_path, self._new_pictures))
            self._image_file = None
        if not self._shards and not self.photographs:
            raise DataError("no recordings and no photographs: nothing was written")
        rated, rated_hash = self.facts.ratings, self.facts.ratings_sha256
        if self.ratings is not None:
            rated, rated_hash = self._save_ratings(self.ratings), self.ratings.sha256
        ids = np.array(self._ids, ID_TABLE)
        if self._store is not None:
            ids = np.concatenate([self._store._ids, ids])
        ids.sort(order="id")
        sha256 = store_hash(ids, self.photographs, rated_hash)
        ids_file = f"ids-{sha256[:16]}.npy"
        self._save_ids(ids, self.folder / ids_file)
        facts = replace(
            self.facts,
            simulated=self._simulated,
            sha256=sha256,
            streams=self.streams,
            shards=tuple(self._shards),
            images=tuple(self._images),
            ids=ids_file,
            duplicates=tuple(self.duplicates),
            skipped=tuple(self.skipped),
            photographs=self.photographs,
            ratings=rated,
            ratings_sha256=rated_hash,
        )
        if self._store is not None and Facts.load(self.folder) != self.facts:
            raise DataError(f"{self.folder} was changed by another process; open it again and repeat")
        part = self.folder / f"{FACTS}.part-{os.getpid()}"
        self._written.append(part)
        self._note(part)
        part.write_text(facts.text(), encoding="utf-8")
        if self.durable:
            to_disk(*(path for path in self._written if path.exists()), self.folder)
        part.replace(self.folder / FACTS)
        if self.durable:
            to_disk(self.folder)
        self._done = True
        if self._store is not None and self.facts.ids != ids_file:
            (self.folder / self.facts.ids).unlink(missing_ok=True)
        if self.facts.ratings is not None and self.facts.ratings != rated:
            (self.folder / self.facts.ratings.file).unlink(missing_ok=True)
        return facts

    def publish(self, path: Path) -> Facts:
        """Finish, and give the folder its name."""
        facts = self.finish()
        self._done = False
        try:
            self.folder.rename(path)
        except OSError as error:
            raise DataError(f"{path} cannot be made: {error.strerror}") from error
        if self.durable:
            to_disk(path.parent)
        self._done = True
        return facts

    def _met(self, id: str) -> tuple[str | None, str] | None:
        if id in self._seen:
            return self._seen[id]
        if self._store is not None and id in self._store:
            info = self._store.info(id)
            return item_of(info), info.source or id
        return None

    def _save_ids(self, ids: np.ndarray, path: Path) -> None:
        part = path.with_name(f"{path.name}.part-{os.getpid()}")
        self._written += [part, path]
        # The list that stands now, too: it goes last, and a kill may come before that.
        self._note(part, path, self.folder / self.facts.ids)
        with part.open("wb") as file:
            np.save(file, ids, allow_pickle=False)
        part.replace(path)

    def _save_ratings(self, ratings: Ratings) -> StoredFile:
        """Write them under a name of their own, so that the old ones stand until ``dataset.json`` is replaced."""
        known = self.items
        if strange := [item for item in ratings.items if item not in known]:
            raise DataError(
                f"ratings must be of items in the store, got {', '.join(strange[:5])}"
                f"{' …' if len(strange) > 5 else ''}; an item is a recording's label item, else its material, or the "
                "material of a photograph"
            )
        path = self._new_file("ratings", 0)
        write_ratings(path, ratings)
        return _stored(path, len(ratings))

    def _keep_picture(self, recording: Recording, photograph: Photograph | None) -> str | None:
        if recording.image is not None:
            key = image_key(recording.image)
            if key in self._pictures:
                return key
            photograph = photograph_of(recording.image)
        if photograph is None:
            return None
        self._write_picture(photograph)
        return photograph.key

    def _write_picture(self, photograph: Photograph) -> None:
        if photograph.key in self._pictures:
            return
        if self._image_file is None:
            columns = {"key": pa.string(), "mm_per_pixel": pa.float64(), "image": pa.binary()}
            self._picture_path = self._new_file("images", len(self._images))
            self._image_file = _parquet(self._picture_path, pa.schema(columns))
        row = {"key": photograph.key, "mm_per_pixel": photograph.mm_per_pixel, "image": photograph.data}
        self._image_file.write_table(pa.Table.from_pylist([row], schema=self._image_file.schema))
        self._pictures.add(photograph.key)
        self._new_pictures += 1

    def _write_group(self) -> None:
        if not self._rows:
            return
        if self._shard is None:
            self._shard_path = self._new_file("shard", len(self._shards))
            self._shard = _parquet(self._shard_path, schema(self.streams))
        columns = _columns([row for row, _ in self._rows], [held for _, held in self._rows], self.streams)
        table = pa.Table.from_arrays(columns, schema=self._shard.schema)
        self._shard.write_table(table, row_group_size=len(self._rows))
        self._rows.clear()
        self._shard_bytes += self._bytes
        self._bytes = 0

    def _close_shard(self) -> None:
        self._write_group()
        if self._shard is not None:
            self._shard.close()
            self._shards.append(_stored(self._shard_path, self._shard_rows))
        self._shard = None
        self._shard_rows = self._shard_bytes = 0

    def _new_file(self, kind: str, number: int) -> Path:
        # The suffix keeps two processes that add at once, and what a killed one left, apart.
        suffix = "" if self._store is None else f"-{os.urandom(4).hex()}"
        path = self.folder / f"{kind}-{number:05d}{suffix}.parquet"
        self._written.append(path)
        self._note(path)
        return path

    def _note(self, *paths: Path) -> None:
        """Write down what is about to be written, so that what a kill leaves of it is known and can be removed."""
        if self.durable and self._store is not None:
            with self._noted.open("a", encoding="utf-8") as file:
                file.writelines(f"{path.name}\n" for path in paths)
                file.flush()
                os.fsync(file.fileno())


def _columns(
    rows: list[dict[str, Any]], held: list[Mapping[str, Signal]], streams: Mapping[str, StreamFacts]
) -> list[pa.Array]:
    """Return the columns of one row group, in the order of `layout.schema`."""
    columns = [pa.array([row[name] for row in rows], kind) for name, kind in INFO_COLUMNS.items()]
    for name, facts in streams.items():
        signals = [recording.get(name) for recording in held]
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


def _parquet(path: Path, columns: pa.Schema) -> pq.ParquetWriter:
    """Return a writer whose column chunks are one plain page each; see `layout`."""
    return pq.ParquetWriter(
        path,
        columns,
        compression="none",
        use_dictionary=False,
        write_statistics=False,
        data_page_size=2**31 - 1,
    )


def _stored(path: Path, rows: int) -> StoredFile:
    return StoredFile(path.name, rows, path.stat().st_size, file_hash(path))


def _check_names(where: str, name: str, signal: Signal) -> None:
    for text in (name, *signal.axes):
        if not _NAME.fullmatch(text):
            raise DataError(f"{where}: names of streams and axes must be letters, digits, _+-; got {text!r}")
    if len(signal) > MOST_SAMPLES:
        raise DataError(
            f"{where}: {name} must be at most {MOST_SAMPLES} samples, got {len(signal)}; cut it first"
        )


def _host() -> str:
    return re.sub(r"[^A-Za-z0-9]+", "_", socket.gethostname()) or "host"
