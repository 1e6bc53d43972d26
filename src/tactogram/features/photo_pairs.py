"""Weak pairs of photograph and spectrogram picture: two things of one material that were never registered.

A pair is a crop of a photograph and a crop of a recording of the same material (Neshov et al. 2026, Sec. 4.1,
"Extended Data"). What is split before what is the protocol:

* ``source-split`` (ours, the default): photographs and recordings are split before anything is cut or paired; the
  pairs of a part are of that part's alone.
* ``crop-split`` (our reading of the paper, which says that images and spectrograms do not overlap between subsets):
  the crops of all photographs and of all recordings are split 80/10/10 in each material, then paired. No crop is
  in two parts, but sibling crops of one photograph or recording are, and at the published sizes any two of those
  overlap (they lie at most 224 of 256 pixels, or 120 of 256 frames, apart).
* ``pair-then-split``: all crops are paired, then the pairs are split 80/10/10. The same crops are in every part.

`pair_leak` measures what each leaks.
"""

from __future__ import annotations

import zlib
from collections import OrderedDict, deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any, Literal, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.features.pair_sources import PhotoSource, RecordingSource, sources
from tactogram.features.photo_crops import PhotoCrops, to_network
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.model import Example

__all__ = [
    "LEAKS",
    "SHARES",
    "PairBatch",
    "Part",
    "PhotoCrops",
    "Protocol",
    "WeakPairs",
    "rng_of",
    "shuffled",
    "weak_pairs",
]

Protocol = Literal["source-split", "crop-split", "pair-then-split"]
Part = Literal["train", "validation", "test"]

SHARES: Mapping[Part, tuple[float, float]] = {
    "train": (0.0, 0.8),
    "validation": (0.8, 0.9),
    "test": (0.9, 1.0),
}
"""Where each part lies among the shuffled crops or pairs of a material, where those are split (Sec. 4.1)."""

LEAKS: Mapping[Protocol, str] = {
    "source-split": "",
    "crop-split": "crops of one photograph or recording are in every part, and overlap",
    "pair-then-split": "the same crops of photographs and recordings are in every part; only their pairing differs",
}
"""What each protocol lets pass from training to test."""


@dataclass(frozen=True, eq=False)
class PairBatch:
    """Some pairs.

    Parameters
    ----------
    photo : float32 tensor, shape (pair, channel, size, size), in [-1, 1]
    picture : float32 tensor, shape (pair, 1, rows, columns), in [-1, 1]
    label : int64 tensor, shape (pair,)
        Place in `WeakPairs.materials`; -1 for a material that is not among them.
    ids : tuple of str
        The recording of each pair.
    photos : tuple of str
        The photograph of each pair: its key.
    """

    photo: Tensor
    picture: Tensor
    label: Tensor
    ids: tuple[str, ...]
    photos: tuple[str, ...]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.label)

    def to(self, device: torch.device | str) -> Self:
        """Return the same pairs on ``device``."""
        moved = {name: getattr(self, name).to(device) for name in ("photo", "picture", "label")}
        return replace(self, **moved)


class WeakPairs:
    """Pairs by number; `weak_pairs` makes them. Crops are made when asked for, and the last ones kept.

    Parameters
    ----------
    photos : sequence of PhotoSource
    recordings : sequence of RecordingSource
    pairs : int64 array, shape (pair, 2)
        Number of the photograph's crop and of the recording's; crop k of source s is ``s * crops + k``.
    picture, crops, seed, materials, protocol, cache_mib
        As in `weak_pairs`.
    """

    def __init__(
        self,
        photos: Sequence[PhotoSource],
        recordings: Sequence[RecordingSource],
        pairs: NDArray[np.int64],
        picture: SpectrogramPicture,
        crops: PhotoCrops,
        *,
        seed: int,
        materials: Sequence[str],
        protocol: Protocol,
        cache_mib: float,
    ) -> None:
        self.photo_sources, self.recording_sources = tuple(photos), tuple(recordings)
        self.pairs, self.picture, self.crops, self.seed = pairs, picture, crops, seed
        self.materials, self.protocol = tuple(materials), protocol
        place = {name: number for number, name in enumerate(self.materials)}
        self._labels = np.array([place.get(source.material, -1) for source in self.photo_sources], np.int64)
        self._kept = _ArrayCache(round(cache_mib * 2**20))

    @property
    def leaks(self) -> str:
        """What the protocol lets pass from training to test; empty where nothing does."""
        return LEAKS[self.protocol]

    @property
    def labels(self) -> NDArray[np.int64]:
        """Place of each pair's material in `materials`, -1 if it is not there; shape (pair,)."""
        return self._labels[self.pairs[:, 0] // self.crops.per_photo]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.pairs)

    def batch(self, places: Sequence[int] | NDArray[np.int64]) -> PairBatch:
        """Return the pairs at ``places``, shape (pair,), each from 0; a pair is the same however it is asked for."""
        places = np.asarray(places, np.int64)
        chosen = self.pairs[places]
        photos = [self.photo_sources[crop // self.crops.per_photo] for crop in chosen[:, 0]]
        recordings = [self.recording_sources[crop // self.crops.per_recording] for crop in chosen[:, 1]]
        pixels = np.stack([self.photo_crop(int(crop)) for crop in chosen[:, 0]])
        return PairBatch(
            photo=to_network(pixels),
            picture=torch.from_numpy(np.stack([self.picture_crop(int(crop)) for crop in chosen[:, 1]])),
            label=torch.from_numpy(self._labels[chosen[:, 0] // self.crops.per_photo]),
            ids=tuple(recording.id for recording in recordings),
            photos=tuple(photo.key for photo in photos),
        )

    def places(self, number: int, size: int) -> NDArray[np.int64]:
        """Return the places of batch ``number``, int64, shape (size,).

        Every pair once per epoch, each epoch in an order of its own; a batch may end one epoch and begin the next.
        Depends on the seed, ``number`` and ``size`` alone.
        """
        return shuffled(len(self), size, number, seed=self.seed)

    def batches(self, size: int, *, start: int = 0, workers: int = 0) -> Iterator[PairBatch]:
        """Yield batches of ``size`` pairs from number ``start`` on, without end.

        Parameters
        ----------
        size : int
        start : int
        workers : int
            Threads that make the next batches while this one is used; with 0 each is made when asked for. The
            batches are the same.
        """
        if not workers:
            while True:
                yield self.batch(self.places(start, size))
                start += 1
        ahead: deque[Future[PairBatch]] = deque()
        with ThreadPoolExecutor(workers) as pool:
            try:
                while True:
                    while len(ahead) <= workers:
                        ahead.append(pool.submit(self.batch, self.places(start, size)))
                        start += 1
                    yield ahead.popleft().result()
            finally:
                pool.shutdown(wait=False, cancel_futures=True)

    def photo_place(self, crop: int) -> tuple[int, int]:
        """Return top and left of crop ``crop`` in its source, pixels."""
        source, rng = self._photo_draw(crop)
        return self.crops.place(source.rows, source.columns, rng)

    def photo_crop(self, crop: int) -> NDArray[np.uint8]:
        """Return crop ``crop`` of the photographs, uint8, shape (channel, size, size)."""
        source, rng = self._photo_draw(crop)
        return self._kept.get(("photo", crop), lambda: self.crops.random(source.image(), rng))

    def picture_place(self, crop: int) -> int:
        """Return the first frame of crop ``crop`` in its source."""
        source, rng = self._recording_draw(crop)
        return int(rng.integers(self.picture.places(source.length)))

    def picture_crop(self, crop: int) -> NDArray[np.float32]:
        """Return crop ``crop`` of the recordings, float32, shape (1, rows, columns), in [-1, 1]."""

        def make() -> NDArray[np.float32]:
            first = self.picture_place(crop)
            start, stop = self.picture.span(first)
            samples = torch.tensor(self._recording_draw(crop)[0].samples()[start:stop])
            made: NDArray[np.float32] = self.picture.crop(samples, first - start // self.picture.hop).numpy()
            return made

        return self._kept.get(("picture", crop), make)

    def _photo_draw(self, crop: int) -> tuple[PhotoSource, np.random.Generator]:
        source, number = divmod(crop, self.crops.per_photo)
        photo = self.photo_sources[source]
        return photo, rng_of(self.seed, "photo", photo.key, photo.top, photo.left, number)

    def _recording_draw(self, crop: int) -> tuple[RecordingSource, np.random.Generator]:
        source, number = divmod(crop, self.crops.per_recording)
        recording = self.recording_sources[source]
        return recording, rng_of(self.seed, "recording", recording.id, recording.start, number)


def weak_pairs(
    examples: Sequence[Example] | Mapping[str, Sequence[Example]],
    picture: SpectrogramPicture,
    crops: PhotoCrops,
    *,
    seed: int,
    protocol: Protocol = "source-split",
    part: Part = "train",
    materials: Sequence[str] | None = None,
    cache_mib: float = 384,
) -> WeakPairs:
    """Return the pairs of a part.

    Every crop of a material is in each of ``crops.repeats`` random pairings of it; where there are fewer crops of
    one kind than of the other, they come as evenly often as can be.

    Parameters
    ----------
    examples : sequence of Example, or mapping from str to such
        ``source-split``: the examples of the part. The other two protocols leak: they need those of all parts,
        by name, e.g. ``{"train": …, "validation": …, "test": …}``. Signals of one axis.
    picture : SpectrogramPicture
    crops : PhotoCrops
    seed : int
        Of crops, augmentation, pairing and order. Leaky protocols: the same for all parts.
    protocol : {"source-split", "crop-split", "pair-then-split"}
        What is split before what.
    part : {"train", "validation", "test"}
        Which share of the crops or pairs; of no effect with ``source-split``.
    materials : sequence of str, optional
        The classes; by default those of ``examples``, sorted.
    cache_mib : float
        How much memory finished crops may take, MiB. More data than that is recreated when asked for.

    Raises
    ------
    ParameterError
        If an argument is not one of these; a material has recordings and no photograph; a photograph is smaller
        than a crop, or a recording shorter than a picture; nothing is left for a part.
    """
    if protocol not in LEAKS:
        raise ParameterError(f"protocol must be one of {', '.join(LEAKS)}, got {protocol!r}")
    if part not in SHARES:
        raise ParameterError(f"part must be one of {', '.join(SHARES)}, got {part!r}")
    if protocol != "source-split" and not isinstance(examples, Mapping):
        raise ParameterError(
            f"protocol {protocol} leaks ({LEAKS[protocol]}): it needs the examples of all parts, by name"
        )
    held = list(examples.values()) if isinstance(examples, Mapping) else [examples]
    photos, recordings = sources(held, picture, crops)
    shown = sorted({source.material for source in photos})
    found = []
    for name in shown:
        photo = _crop_numbers(photos, name, crops.per_photo)
        recording = _crop_numbers(recordings, name, crops.per_recording)
        if protocol == "crop-split":
            photo = _share(photo, part, rng_of(seed, "split", "photo", name))
            recording = _share(recording, part, rng_of(seed, "split", "recording", name))
        if not (len(photo) and len(recording)):
            raise ParameterError(f"protocol {protocol} leaves nothing of {name} for {part}: take more crops")
        pairings = [
            _pairing(photo, recording, rng_of(seed, "pairs", name, repeat)) for repeat in range(crops.repeats)
        ]
        pairs = np.concatenate(pairings)
        if protocol == "pair-then-split":
            pairs = _share(pairs, part, rng_of(seed, "split", "pairs", name))
        found.append(pairs)
    return WeakPairs(
        photos,
        recordings,
        np.concatenate(found),
        picture,
        crops,
        seed=seed,
        materials=shown if materials is None else materials,
        protocol=protocol,
        cache_mib=cache_mib,
    )


def shuffled(count: int, size: int, number: int, *, seed: int) -> NDArray[np.int64]:
    """Return batch ``number`` of ``size`` out of ``count`` things, each once per epoch, int64, shape (size,).

    Each epoch has an order of its own; a batch may end one epoch and begin the next.
    """
    first, last = number * size, (number + 1) * size
    epochs = range(first // count, -(-last // count))
    order = np.concatenate([rng_of(seed, "epoch", epoch).permutation(count) for epoch in epochs])
    begin = first - epochs[0] * count
    return order[begin : begin + size]


def rng_of(seed: int, *purpose: str | int) -> np.random.Generator:
    """Return numpy's generator for one purpose; texts count by their checksum."""
    numbers = [zlib.crc32(p.encode()) if isinstance(p, str) else p for p in purpose]
    return np.random.default_rng([seed, *numbers])


def _crop_numbers(
    held: Sequence[PhotoSource | RecordingSource], material: str, count: int
) -> NDArray[np.int64]:
    members = np.array([i for i, source in enumerate(held) if source.material == material], np.int64)
    return (members[:, None] * count + np.arange(count)).ravel()


def _share(items: NDArray[np.int64], part: Part, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return the share of ``items`` (item, ...) that is of ``part``, shuffled."""
    begin, end = (round(bound * len(items)) for bound in SHARES[part])
    return rng.permutation(items)[begin:end]


def _pairing(
    photo: NDArray[np.int64], recording: NDArray[np.int64], rng: np.random.Generator
) -> NDArray[np.int64]:
    """Return each crop of the more numerous kind with one of the other at random, shape (pair, 2)."""
    count = max(len(photo), len(recording))
    columns = []
    for crops in (photo, recording):
        rounds = -(-count // len(crops))
        columns.append(np.concatenate([rng.permutation(crops) for _ in range(rounds)])[:count])
    return np.stack(columns, axis=1)


class _ArrayCache:
    """Arrays by key, the last used ones up to a number of bytes. Threads may share it."""

    def __init__(self, most_bytes: int) -> None:
        self._most, self._bytes, self._lock = most_bytes, 0, Lock()
        self._arrays: OrderedDict[tuple[str, int], NDArray[Any]] = OrderedDict()

    def get(self, key: tuple[str, int], make: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        with self._lock:
            if key in self._arrays:
                self._arrays.move_to_end(key)
                return self._arrays[key]
        array = make()
        with self._lock:
            if key not in self._arrays and array.nbytes <= self._most:
                self._arrays[key] = array
                self._bytes += array.nbytes
            while self._bytes > self._most:
                self._bytes -= self._arrays.popitem(last=False)[1].nbytes
        return array
