"""Store: recordings on disk, read on demand."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import overload

import numpy as np

from tactogram.datasets.ratings.ratings import Ratings, read_ratings
from tactogram.datasets.recording import Recording, RecordingInfo, content_id
from tactogram.datasets.store.arrays import StoreArrays, common_lengths, stacked
from tactogram.datasets.store.layout import (
    MissingFileError,
    StoreInfo,
    StoreStreamInfo,
    axis_column,
    facts_hash,
    file_hash,
    file_size,
    reading,
)
from tactogram.datasets.store.photographs import Photograph, PhotographFiles, image_key
from tactogram.datasets.store.remote import BlockReader, RemotePath, location, readable
from tactogram.datasets.store.shards import Shard, places_of
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal


def open_store(path: Path | str) -> Store:
    """Open the store in folder ``path``, or at a URL such as ``s3://bucket/path``; reads none of its shards.

    Raises
    ------
    DataError
        If it is not a store, is an unfinished one or of an unknown format version, or cannot be reached.

    Examples
    --------
    >>> store = tactogram.open_store("surfaces")   # doctest: +SKIP
    >>> store.signal(store.index[0].id, "acceleration")   # doctest: +SKIP
    """
    store = Store(location(path))
    if store.facts.unfinished is not None:
        raise DataError(path, "unfinished; repeat the import or simulation that was making it")
    return store


class Store:
    """Recordings on disk, created by `create_store` or an import and opened by `open_store`.

    An open store keeps its content, even if recordings are added meanwhile.

    Attributes
    ----------
    folder : Path or RemotePath
    facts : StoreInfo
        Content of ``dataset.json``: name, licence, shards, duplicates, skipped files.
    index : sequence of RecordingInfo
        Metadata of each recording, read lazily, in the order in which they were added.
    """

    def __init__(self, folder: Path | RemotePath) -> None:
        self.folder = folder
        self.facts = StoreInfo.load(folder)
        self.index: Sequence[RecordingInfo] = _Index(self)
        try:
            self._places = places_of(folder, self.facts)
        except MissingFileError:
            # dataset.json was replaced since it was read, and then the list of ids was removed.
            self.facts = StoreInfo.load(folder)
            self._places = places_of(folder, self.facts)
        self._photographs = PhotographFiles(folder, self.facts.images)
        self._blocks = BlockReader()
        self._count = self.facts.rows

    def __reduce__(self) -> tuple[Callable[[Path | str], Store], tuple[Path | str]]:
        """Pickle as the path: another process opens the store itself."""
        return open_store, (self.path,)

    @property
    def path(self) -> Path | str:
        """The folder, or the URL, with which `open_store` opens it."""
        return self.folder if isinstance(self.folder, Path) else str(self.folder)

    def __repr__(self) -> str:
        simulated = ", simulated" if self.simulated else ""
        return f"<Store {self.name!r}: {len(self)} recordings{simulated}, in {self.path}>"

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, key: int | str) -> Recording: ...
    @overload
    def __getitem__(self, key: slice) -> list[Recording]: ...
    def __getitem__(self, key: int | str | slice) -> Recording | list[Recording]:
        """Return a recording by its place or id, or those of a slice; see `read`."""
        if isinstance(key, str):
            return self.read(key)
        infos = self.index[key]
        return self.read(infos.id) if isinstance(infos, RecordingInfo) else [self.read(i.id) for i in infos]

    def __iter__(self) -> Iterator[Recording]:
        for info in self.index:
            yield self.read(info.id)

    def __contains__(self, id: object) -> bool:
        return isinstance(id, str) and self._places.find(id) is not None

    @property
    def name(self) -> str:
        """Name of the data set."""
        return self.facts.name

    @property
    def licence(self) -> str:
        """Licence, as the source states it."""
        return self.facts.licence

    @property
    def simulated(self) -> bool:
        """Whether any of it was computed rather than measured."""
        return self.facts.simulated

    @property
    def sha256(self) -> str:
        """Hash of all samples, photographs and labels: the identity of the data, whatever its order."""
        return self.facts.sha256

    @property
    def streams(self) -> Mapping[str, StoreStreamInfo]:
        """Unit, domain and axes of each stream."""
        return self.facts.streams

    @property
    def _ids(self) -> np.ndarray:
        return self._places.ids

    @cached_property
    def ratings(self) -> Ratings | None:
        """Ratings of its items; None if there are none."""
        stored = self.facts.ratings
        if stored is None:
            return None
        path = self.folder / stored.file
        with reading(path):
            return read_ratings(readable(path), name=str(path))

    def place(self, id: str) -> int:
        """Return the place of one recording in the order in which they are stored."""
        number, row = self._found(id)
        return self._places.begins[number] + row

    def info(self, id: str) -> RecordingInfo:
        """Return the metadata of one recording."""
        shard, row = self._locate(id)
        return shard.infos[row]

    def streams_of(self, id: str) -> tuple[str, ...]:
        """Return the names of one recording's streams."""
        shard, row = self._locate(id)
        return tuple(name for name in self.streams if shard.has(name, row))

    def length(self, id: str, stream: str) -> int:
        """Return the number of samples per axis."""
        shard, row = self._stream(id, stream)
        return int(shard.lengths[stream][row])

    def rate(self, id: str, stream: str) -> float:
        """Return the rate in Hz, or samples per mm for a stream over displacement."""
        shard, row = self._stream(id, stream)
        return float(shard.rates[stream][row])

    def signal(self, id: str, stream: str, *, start: int = 0, stop: int | None = None) -> Signal:
        """Return samples ``start`` to ``stop`` (as in a slice) of one stream; nothing else is read.

        Raises
        ------
        ParameterError
            If there is no such recording or stream, or the slice is empty.
        DataError
            If the shard is damaged.
        """
        shard, row = self._stream(id, stream)
        length = int(shard.lengths[stream][row])
        first, last, _ = slice(start, stop).indices(length)
        if last <= first:
            raise ParameterError.must("samples", f"lie in 0 to {length} of {id}, got {start} to {stop}")
        facts, axes = self.streams[stream], shard.axes[stream][row]
        samples = np.stack([shard.read(axis_column(stream, axis), row, first, last) for axis in axes])
        samples.flags.writeable = False
        rate = float(shard.rates[stream][row])
        return Signal(samples, rate, facts.unit, axes, "time" if facts.domain == "time" else "displacement")

    def read(self, id: str) -> Recording:
        """Return a whole recording, photograph included."""
        info = self.info(id)
        streams = {name: self.signal(id, name) for name in self.streams_of(id)}
        values = {f.name: getattr(info, f.name) for f in fields(RecordingInfo)}
        return Recording(streams=streams, image=self.image(id), **values)

    def to_numpy(
        self, stream: str | None = None, *, seconds: float | None = None, by: str = "session"
    ) -> StoreArrays:
        """Return one stream of all recordings that have it as arrays, for scikit-learn or PyTorch.

        Parameters
        ----------
        stream : str, optional
            By default ``acceleration``, or the first.
        seconds : float, optional
            Of each recording, from its beginning (mm over displacement). By default all of it, where all are equally
            long.
        by : str
            Field of the recordings whose equal values make a group; a recording without a value is its own group.

        Returns
        -------
        X : float32 array, shape (recording, axis, time)
        y : array of str, shape (recording,)
            Materials.
        groups : array of str, shape (recording,)
            As scikit-learn's ``GroupKFold`` takes them.

        Raises
        ------
        ParameterError
            If the recordings differ in length, rate or axes, or there is no such stream or field.
        """
        if by not in RecordingInfo.__dataclass_fields__:
            raise ParameterError.must("by", "be a field of the recordings, such as session or subject", by)
        stream = stream or Preparation().stream_of(list(self.streams))
        if stream not in self.streams:
            raise ParameterError.one_of("stream", self.streams, stream)
        infos = [info for info in self.index if stream in self.streams_of(info.id)]
        held = [self.length(info.id, stream) for info in infos]
        lengths = common_lengths(held, [self.rate(info.id, stream) for info in infos], seconds)
        signals = [self.signal(info.id, stream, stop=n) for info, n in zip(infos, lengths, strict=True)]
        return stacked(infos, signals, by)

    def image(self, id: str) -> Image | None:
        """Return the photograph of one recording, or None."""
        shard, row = self._locate(id)
        key = shard.images[row]
        return None if key is None else self.photograph(key)

    def image_id(self, id: str) -> str | None:
        """Return the key of the photograph of one recording: the same key, the same picture."""
        shard, row = self._locate(id)
        return shard.images[row]

    def photograph(self, key: str) -> Image:
        """Return the photograph of this key; the last few are cached."""
        return self._photographs.image(key)

    def photograph_size(self, key: str) -> tuple[int, int]:
        """Return rows and columns of the photograph of this key, without caching it."""
        return self._photographs.size(key)

    def photograph_keys(self) -> tuple[str, ...]:
        """Return the keys of all photographs."""
        return self._photographs.keys

    def photographs_of(self, material: str) -> tuple[str, ...]:
        """Return the keys of all photographs of a material, sorted: its own and those of its recordings."""
        return self.photographs_by_material.get(material, ())

    @cached_property
    def photographs_by_material(self) -> Mapping[str, tuple[str, ...]]:
        """Keys of all photographs of each material that has any, sorted: its own and those of its recordings."""
        keys: dict[str, set[str]] = {material: set(held) for material, held in self.facts.photographs.items()}
        shards = (self._shard(number) for number in range(len(self._places.shards)))
        rows = (row for shard in shards for row in zip(shard.infos, shard.images, strict=True))
        for info, key in islice(rows, len(self)):
            if info.material is not None and key is not None:
                keys.setdefault(info.material, set()).add(key)
        return {material: tuple(sorted(held)) for material, held in sorted(keys.items())}

    def holds(self, recording: Recording, photograph: Photograph | None = None) -> bool:
        """Return whether it holds this recording with the same metadata; ``photograph`` replaces a missing image."""
        rank = self._places.rank(recording.id)
        if recording.image is not None:
            key: str | None = image_key(recording.image)
        else:
            key = None if photograph is None else photograph.key
        return rank is not None and bool(self._ids["facts"][rank] == facts_hash(recording, key))

    def _locate(self, id: str) -> tuple[Shard, int]:
        number, row = self._found(id)
        return self._shard(number), row

    def _found(self, id: str) -> tuple[int, int]:
        position = self._places.find(id)
        if position is None:
            raise ParameterError.must("recording", f"be one of the {len(self)} in {self.path}", id)
        return position

    def _stream(self, id: str, stream: str) -> tuple[Shard, int]:
        shard, row = self._locate(id)
        if stream not in self.streams or not shard.has(stream, row):
            raise ParameterError.one_of(f"stream of {id}", self.streams_of(id), stream)
        return shard, row

    def _info_at(self, index: int) -> RecordingInfo:
        number = bisect_right(self._places.ends, index)
        return self._shard(number).infos[index - self._places.begins[number]]

    def _shard(self, number: int) -> Shard:
        places = self._places
        if number not in places.opened:
            stored = places.shards[number]
            places.opened[number] = Shard(self.folder / stored.file, stored, self.streams, self._blocks)
        return places.opened[number]


class _Index(Sequence[RecordingInfo]):
    """Metadata of every recording, read shard by shard on demand."""

    def __init__(self, store: Store) -> None:
        self._store = store

    def __len__(self) -> int:
        return len(self._store)

    @overload
    def __getitem__(self, index: int) -> RecordingInfo: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[RecordingInfo]: ...
    def __getitem__(self, index: int | slice) -> RecordingInfo | Sequence[RecordingInfo]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        if not -len(self) <= index < len(self):
            raise IndexError(f"index must be below {len(self)}, got {index}")
        return self._store._info_at(index % len(self))

    def __iter__(self) -> Iterator[RecordingInfo]:
        for index in range(len(self)):
            yield self._store._info_at(index)


def problems(store: Store, *, progress: Callable[[int, int], None] | None = None) -> list[str]:
    """Return what is wrong with a store, one line each; empty if every byte is as it was written.

    Every file is hashed, every recording read, and its id recomputed. ``progress`` is called with the number of
    recordings checked and their total.
    """
    faults = []
    for stored in store.facts.files:
        path = store.folder / stored.file
        if not path.is_file():
            faults.append(f"{path}: missing; import the data again")
        elif file_size(path) != stored.bytes or file_hash(path) != stored.sha256:
            faults.append(f"{path}: changed since it was written (sha256 differs); import the data again")
    facts = store.facts
    if store._places.mended or not store._places.is_of(facts):
        faults.append(
            f"{store.folder / facts.ids}: is not the list of ids, or of photographs, that was written"
        )
    if faults:
        return faults
    pictures: set[str | None] = {key for held in store.facts.photographs.values() for key in held}
    for done, info in enumerate(store.index, 1):
        try:
            streams = {name: store.signal(info.id, name) for name in store.streams_of(info.id)}
            if content_id(streams) != info.id:
                faults.append(f"{info.source}: samples of {info.id} do not match its id")
            pictures.add(store.image_id(info.id))
        except TactogramError as error:
            faults.append(str(error))
        if progress is not None:
            progress(done, len(store))
    for key in sorted(pictures - {None}, key=str):
        try:
            if image_key(store.photograph(str(key))) != key:
                faults.append(f"{store.path}: photograph {key} does not match its key")
        except TactogramError as error:
            faults.append(str(error))
    return faults
