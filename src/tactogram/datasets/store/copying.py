"""Copies of stores: to an object store, back, or to another folder."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import pyarrow.fs as fs

from tactogram.datasets.store.layout import FACTS, StoreInfo, file_hash
from tactogram.datasets.store.pending import new_folder
from tactogram.datasets.store.remote import RemotePath, arrow_place, errors, location
from tactogram.datasets.store.store import Store, open_store
from tactogram.errors import DataError


def copy_store(
    source: Path | str, target: Path | str, *, progress: Callable[[int, int], None] | None = None
) -> Store:
    """Copy the store ``source`` to ``target``, and open it; each is a folder or a URL such as ``s3://bucket/path``.

    Every file is compared with its hash where it is on a disk, before it is sent or after it has come. The copy becomes
    a store when all of it is there: one that was interrupted is begun again. A target that is the same store already is
    left as it is. ``progress`` is called with the bytes copied and their total.

    Raises `DataError` if the source is damaged, the target holds something else, or one of them cannot be reached.
    """
    store, place = open_store(source), location(target)
    if _holds(place, store):
        return open_store(target)
    with new_folder(place) if isinstance(place, Path) else nullcontext(place) as folder:
        _copy_files(store, folder, progress)
    return open_store(target)


def _holds(place: Path | RemotePath, store: Store) -> bool:
    """Return whether ``place`` holds ``store`` already; refuses a place that holds something else."""
    held = (place / FACTS).is_file()
    if held and StoreInfo.load(place).sha256 == store.sha256:
        return True
    if held or (isinstance(place, Path) and place.exists()):
        raise DataError(f"{place} exists and holds something else than {store.path}; choose another place")
    return False


def _copy_files(store: Store, folder: Path | RemotePath, progress: Callable[[int, int], None] | None) -> None:
    done, total = 0, sum(stored.bytes for stored in store.facts.files)
    for stored in store.facts.files:
        _copy(store.folder / stored.file, folder / stored.file, stored.sha256)
        done += stored.bytes
        if progress is not None:
            progress(done, total)
    _copy(store.folder / store.facts.ids, folder / store.facts.ids, None)
    facts = folder / FACTS  # last: it makes the folder a store
    system, path = arrow_place(facts)
    with _errors(facts), system.open_output_stream(path) as out:
        out.write(store.facts.text().encode())


def _copy(source: Path | RemotePath, target: Path | RemotePath, sha256: str | None) -> None:
    """Copy a file; `DataError` if it is missing, or its hash, where given, is another."""

    def check(path: Path | RemotePath) -> None:
        if sha256 is not None and file_hash(path) != sha256:
            raise DataError(f"{source}: wrong hash: changed since it was written; import the data again")

    (system, path), (target_system, target_path) = arrow_place(source), arrow_place(target)
    try:
        if isinstance(target, RemotePath):
            check(source)
        with _errors(source), _errors(target):
            fs.copy_files(path, target_path, source_filesystem=system, destination_filesystem=target_system)
    except FileNotFoundError as error:
        raise DataError(f"{source}: missing; import the data again") from error
    if isinstance(target, Path):
        check(target)


def _errors(path: Path | RemotePath) -> AbstractContextManager[None]:
    return errors(path) if isinstance(path, RemotePath) else nullcontext()
