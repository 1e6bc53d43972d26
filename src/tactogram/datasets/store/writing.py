"""Creation and extension of stores: in one pass, in flat memory, complete or not at all."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from tactogram.datasets.ratings.ratings import Ratings
from tactogram.datasets.recording import Recording
from tactogram.datasets.store.layout import StoreInfo
from tactogram.datasets.store.pending import part_folder
from tactogram.datasets.store.store import Store, open_store
from tactogram.datasets.store.writer import StoreWriter
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image


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
    with StoreWriter(store.path, store.facts, store, durable=durable) as writer:
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


def new_store(
    path: Path, *, name: str, licence: str, source: str, simulated: bool, durable: bool = False
) -> StoreWriter:
    """Return a writer into a part folder beside ``path``.

    Raises
    ------
    ParameterError
        If ``name`` or ``licence`` is empty.
    """
    if not name:
        raise ParameterError("a store needs a name, got ''")
    if not licence:
        raise ParameterError("a store needs a licence; say 'not stated' where the source states none")
    part = part_folder(path)
    if part.exists():
        shutil.rmtree(part)
    part.mkdir(parents=True)
    empty = StoreInfo(name, licence, source, simulated, "", {}, (), (), "")
    return StoreWriter(part, empty, None, durable=durable)
