"""Creation, extension and copies of stores: in one pass, in little memory, atomic.

`append_recording` is also durable, for recording sessions: all files and their folder are synchronised to the disk
before ``dataset.json`` is replaced, and it after, so that a power cut loses nothing; `recover_store` removes what a
killed process left.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import pyarrow.fs as fs

from tactogram.datasets.ratings.ratings import Ratings
from tactogram.datasets.recording import Recording
from tactogram.datasets.store.layout import FACTS, StoreInfo, file_hash
from tactogram.datasets.store.pending import (
    adopt_part,
    clear_stale_parts,
    clear_unfinished,
    new_folder,
    part_folder,
)
from tactogram.datasets.store.remote import RemotePath, arrow_place, errors, location
from tactogram.datasets.store.store import Store, open_store
from tactogram.datasets.store.writer import StoreWriter
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image
from tactogram.signal.io.atomic import sole_writer
from tactogram.text_files import check_regular

ATTEMPTS = 20
"""Attempts where another process adds to the store at the same moment."""


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
    """Write ``recordings`` to a new store, which appears complete or not at all, and open it.

    Raises `DataError` if ``path`` exists, there are neither recordings nor photographs, one does not fit the others, or
    an unknown item was rated.

    Parameters
    ----------
    path : Path
        A folder that does not exist yet.
    recordings : iterable of Recording
        Read once, with a few at a time in memory. Equal samples are stored once: ``facts.duplicates`` lists the rest.
    name, licence, source : str
        Name of the data set, terms of its use, and origin.
    simulated : bool
        Whether it was computed; also true if any recording is simulated.
    photographs : iterable of (str, Image)
        Materials and photographs of them, besides the recordings' own images; any number of each.
    ratings : Ratings, optional
        Ratings of items (`item_of`).
    """
    path = Path(path)
    check_new(path)
    facts: dict[str, Any] = {"name": name, "licence": licence, "source": source}
    with sole_writer(path), new_store(path, **facts, simulated=simulated) as writer:
        for recording in recordings:
            writer.add(recording)
        for material, image in photographs:
            writer.add_photograph(image, material)
        writer.ratings = ratings
        writer.publish(path)
    return open_store(path)


def check_new(path: Path) -> None:
    """Raise a `DataError` if there is a file or folder at the path of a new store."""
    if path.exists():
        raise DataError(f"{path} must not exist yet; choose another folder, or add to the store")


def add_recordings(
    store: Store,
    recordings: Iterable[Recording],
    *,
    photographs: Iterable[tuple[str, Image]] = (),
    durable: bool = False,
) -> Store:
    """Add recordings, and photographs of materials, to ``store`` and open it again.

    They go to new shards; ``dataset.json`` is replaced last, atomically. Stored ones are left out. ``durable`` waits
    until everything is on the disk, so that it survives a power cut.

    Raises `DataError` if a recording does not fit the others, or the store was changed meanwhile.
    """
    with StoreWriter(store.folder, store.facts, store, durable=durable) as writer:
        for recording in recordings:
            writer.add(recording)
        for material, image in photographs:
            writer.add_photograph(image, material)
        if writer.added:
            writer.finish()
    return open_store(store.path)


def add_ratings(store: Store, ratings: Ratings, *, replace: bool = False) -> Store:
    """Add ``ratings`` of its items to ``store`` and open it again; ``replace`` discards stored ratings.

    Raises `DataError` if there are ratings already and ``replace`` is false, an unknown item was rated, or the store
    was changed meanwhile.
    """
    stored = store.facts.ratings
    if stored is not None and not replace:
        raise DataError(
            f"{store.path} has ratings already ({stored.rows} scores); set replace to discard them"
        )
    with StoreWriter(store.folder, store.facts, store) as writer:
        writer.ratings = ratings
        writer.finish()
    return open_store(store.path)


def new_store(
    path: Path,
    *,
    name: str,
    licence: str,
    source: str,
    simulated: bool,
    durable: bool = False,
    job: str = "",
) -> StoreWriter:
    """Return a writer into a part folder beside ``path``.

    ``job`` identifies what is written, and by which version: if a process of this machine was killed in the same job
    after a checkpoint (`StoreWriter.keep`), the writer goes on from there, after ``tasks_done`` tasks.

    Raises `ParameterError` if ``name`` or ``licence`` is empty.
    """
    if not name:
        raise ParameterError("a store needs a name, got ''")
    if not licence:
        raise ParameterError("a store needs a licence; say 'not stated' where the source states none")
    part = part_folder(path)
    if job and (begun := adopt_part(path, job)):
        return StoreWriter(part, begun, Store(part), durable=durable, job=job)
    if part.exists():
        shutil.rmtree(part)
    part.mkdir(parents=True)
    empty = StoreInfo(name, licence, source, simulated, "", {}, (), (), "")
    return StoreWriter(part, empty, None, durable=durable, job=job)


def append_recording(path: Path, recording: Recording, *, name: str, licence: str, source: str = "") -> Store:
    """Append ``recording`` to the store at ``path``, which is created if missing, and return the store.

    When this returns, the recording is on the disk; when it raises, the store is as it was. ``name``, ``licence`` and
    ``source`` are those of a new store; see `create_store`.

    Raises `DataError` if the store holds the same samples, or the recording does not fit the others; `OSError` if the
    disk is full, or the folder not writable.
    """
    if not path.exists():
        with new_store(
            path, name=name, licence=licence, source=source, simulated=False, durable=True
        ) as writer:
            writer.add(recording)
            writer.publish(path)
        return open_store(path)
    store, added = insert_recording(path, recording)
    if not added:
        raise DataError(
            f"{path} holds the same samples already, as {store.info(recording.id).source or recording.id}; "
            "is a recording being played instead of recorded?"
        )
    return store


def insert_recording(path: Path | str, recording: Recording) -> tuple[Store, bool]:
    """Add ``recording`` to a store unless it is stored; return the store, and whether it was added.

    When this returns, the recording is on the disk. Several processes may do so at once. Errors as `append_recording`.
    """
    for left in reversed(range(ATTEMPTS)):
        store = open_store(path)
        with StoreWriter(store.folder, store.facts, store, durable=True) as writer:
            if not writer.add(recording):
                return store, False
            try:
                writer.finish()
                break
            except DataError:
                if not left:
                    raise
    return open_store(path), True


def recover_store(path: Path) -> tuple[Store | None, list[str]]:
    """Return the store at ``path``, None if missing, and the names of removed leftovers of killed processes."""
    stale = [part.name for part in path.parent.glob(f"{path.name}.part-*")]
    left = {part.name for part in clear_stale_parts(path)}
    removed = [name for name in stale if name not in left]
    if not path.exists():
        return None, removed
    removed += clear_unfinished(path)
    return open_store(path), removed


def copy_store(
    source: Path | str, target: Path | str, *, progress: Callable[[int, int], None] | None = None
) -> Store:
    """Copy the store ``source`` to ``target``, and open it; each is a folder or a URL such as ``s3://bucket/path``.

    Every file is compared with its hash where it is on a disk, before it is sent or after it has come. The copy becomes
    a store when all of it is there: one that was interrupted is begun again. A target that is the same store already is
    left as it is. ``progress`` is called with the bytes copied and their total.

    Raises `DataError` if the source is damaged, the target holds something else, or one of them cannot be reached.
    """
    store, path = open_store(source), location(target)
    if _holds(path, store):
        return open_store(target)
    with new_folder(path) if isinstance(path, Path) else nullcontext(path) as folder:
        _copy_files(store, folder, progress)
    return open_store(target)


def _holds(path: Path | RemotePath, store: Store) -> bool:
    """Return whether ``path`` holds ``store`` already; refuses a place that holds something else."""
    held = (path / FACTS).is_file()
    if held and StoreInfo.load(path).sha256 == store.sha256:
        return True
    if held or (isinstance(path, Path) and path.exists()):
        raise DataError(f"{path} exists and holds something else than {store.path}; choose another place")
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
            raise DataError(source, "wrong hash: changed since it was written; import the data again")

    if isinstance(source, Path) and source.exists():
        check_regular(source)
    (system, path), (target_system, target_path) = arrow_place(source), arrow_place(target)
    try:
        if isinstance(target, RemotePath):
            check(source)
        with _errors(source), _errors(target):
            fs.copy_files(path, target_path, source_filesystem=system, destination_filesystem=target_system)
    except FileNotFoundError as error:
        raise DataError(source, "missing; import the data again") from error
    if isinstance(target, Path):
        check(target)


def _errors(path: Path | RemotePath) -> AbstractContextManager[None]:
    return errors(path) if isinstance(path, RemotePath) else nullcontext()
