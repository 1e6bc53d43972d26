"""Copies of stores: to an object store, back, or to another folder, with a catalogue."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from tactogram.datasets.store.catalogue import write_catalogue
from tactogram.datasets.store.layout import FACTS, StoredFile, StoreInfo
from tactogram.datasets.store.parquet import stored_file
from tactogram.datasets.store.pending import part_folder
from tactogram.datasets.store.remote import RemotePath, location
from tactogram.datasets.store.store import Store, open_store
from tactogram.errors import DataError

PIECE_BYTES = 2**23
"""Bytes that are copied at once."""


def copy_store(
    source: Path | str, target: Path | str, *, progress: Callable[[int, int], None] | None = None
) -> Store:
    """Copy the store ``source`` to ``target``, and open it; each is a folder or a URL such as ``s3://bucket/path``.

    Every file is compared with its hash on the way, and the copy gets a catalogue. It becomes a store when all of it is
    there: a copy that was interrupted is begun again. A target that is the same store already is left as it is.
    ``progress`` is called with the bytes copied and their total.

    Raises `DataError` if the source is damaged, the target holds something else, or one of them cannot be reached.
    """
    store, place = open_store(source), location(target)
    if _holds(place, store):
        return open_store(target)
    with _written(place) as folder:
        facts = store.facts
        if facts.catalogue is None and facts.shards:
            facts = replace(facts, catalogue=_write_catalogue(store, folder))
        elif facts.catalogue is not None:
            _copy(store.folder, folder, facts.catalogue)
        files = [file for file in facts.files if file is not facts.catalogue]
        done, total = 0, sum(file.bytes for file in files)
        for file in files:
            for size in _copied(store.folder / file.file, folder / file.file, file.sha256):
                done += size
                if progress is not None:
                    progress(done, total)
        for _ in _copied(store.folder / facts.ids, folder / facts.ids, None):
            pass
        with _opened(folder / FACTS) as out:  # last: it makes the folder a store
            out.write(facts.text().encode())
    return open_store(target)


def _holds(place: Path | RemotePath, store: Store) -> bool:
    """Return whether ``place`` holds ``store`` already; refuses a place that holds something else."""
    held = (place / FACTS).is_file()
    if held and StoreInfo.load(place).sha256 == store.sha256:
        return True
    if held or (isinstance(place, Path) and place.exists()):
        raise DataError(f"{place} exists and holds something else than {store.path}; choose another place")
    return False


@contextmanager
def _written(place: Path | RemotePath) -> Iterator[Path | RemotePath]:
    """Yield the place to write to: a remote one itself, or a folder beside a local one, which is renamed at the end."""
    if isinstance(place, RemotePath):
        yield place
        return
    part = part_folder(place)
    part.mkdir(parents=True)
    try:
        yield part
        part.rename(place)
    except BaseException:
        shutil.rmtree(part, ignore_errors=True)
        raise


def _write_catalogue(store: Store, folder: Path | RemotePath) -> StoredFile:
    with tempfile.TemporaryDirectory(prefix="tactogram-catalogue-") as name:
        path = Path(name) / f"catalogue-{store.sha256[:16]}.parquet"
        write_catalogue(path, store.folder, store.facts)
        stored = stored_file(path, len(store))
        _copy(Path(name), folder, stored)
        return stored


def _copy(source: Path | RemotePath, target: Path | RemotePath, file: StoredFile) -> None:
    for _ in _copied(source / file.file, target / file.file, file.sha256):
        pass


def _copied(source: Path | RemotePath, target: Path | RemotePath, sha256: str | None) -> Iterator[int]:
    """Copy a file, and yield the size of each piece; `DataError` if its hash is another."""
    digest = hashlib.sha256()
    try:
        with (
            source.open() if isinstance(source, RemotePath) else source.open("rb") as file,
            _opened(target) as out,
        ):
            while piece := file.read(PIECE_BYTES):
                digest.update(piece)
                out.write(piece)
                yield len(piece)
    except FileNotFoundError as error:
        raise DataError(f"{source}: missing; import the data again") from error
    if sha256 is not None and digest.hexdigest() != sha256:
        raise DataError(f"{source}: wrong hash: changed since it was written; import the data again")


@contextmanager
def _opened(path: Path | RemotePath) -> Iterator[Any]:
    if isinstance(path, RemotePath):
        with path.writing() as out:
            yield out
    else:
        with path.open("wb") as out:
            yield out
