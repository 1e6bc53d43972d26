"""Weak pairs: a photograph and a spectrogram picture of one material, not registered.

A pair is a crop of a photograph and a crop of a recording of the same material (Neshov et al. 2026, Sec. 4.1,
"Extended Data"). The protocol is the order of splitting, cutting and pairing:

* ``source-split`` (ours, the default): photographs and recordings are split before anything is cut or paired; the
  pairs of a part come from that part alone.
* ``crop-split`` (our reading of the paper, which states that images and spectrograms do not overlap between subsets):
  the crops of all photographs and of all recordings are split 80/10/10 in each material, then paired. No crop is
  in two parts, but sibling crops of one photograph or recording are, and at the published sizes any two of those
  overlap (they lie at most 224 of 256 pixels, or 120 of 256 frames, apart).
* ``pair-then-split``: all crops are paired, then the pairs are split 80/10/10. The same crops are in every part.

`pair_leak` measures what each leaks.
"""

from __future__ import annotations

import zlib
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

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
"""Range of each part among the shuffled crops or pairs of a material, if those are split (Sec. 4.1)."""

LEAKS: Mapping[Protocol, str] = {
    "source-split": "",
    "crop-split": "crops of one photograph or recording are in every part, and overlap",
    "pair-then-split": "the same crops of photographs and recordings are in every part; only their pairing differs",
}
"""Leak of each protocol from training to test."""


@dataclass(frozen=True, eq=False)
class PairBatch:
    """A batch of pairs."""

    photo: Tensor
    """float32, shape (pair, channel, size, size), in [-1, 1]."""
    picture: Tensor
    """float32, shape (pair, 1, rows, columns), in [-1, 1]."""
    label: Tensor
    """int64, shape (pair,): index in `WeakPairs.materials`; -1 for other materials."""


class WeakPairs:
    """Pairs by number, created by `weak_pairs`. Crops are made on demand, and the last ones cached.

    ``pairs``, int64, shape (pair, 2), are the numbers of the photograph's crop and of the recording's; crop k of source
    s is ``s * crops + k``. The other parameters are those of `weak_pairs`.
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
        label = {name: number for number, name in enumerate(self.materials)}
        self._labels = np.array([label.get(source.material, -1) for source in self.photo_sources], np.int64)
        self._cache = _ArrayCache(round(cache_mib * 2**20))

    @property
    def leaks(self) -> str:
        """Leak of the protocol from training to test; empty if there is none."""
        return LEAKS[self.protocol]

    @property
    def labels(self) -> NDArray[np.int64]:
        """Place of each pair's material in `materials`, -1 for others; int64, shape (pair,)."""
        return self._labels[self.pairs[:, 0] // self.crops.per_photo]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.pairs)

    def batch(self, places: Sequence[int] | NDArray[np.int64]) -> PairBatch:
        """Return the pairs at ``places``, shape (pair,), from 0; a pair is the same in any batch."""
        places = np.asarray(places, np.int64)
        chosen = self.pairs[places]
        pixels = np.stack([self.photo_crop(int(crop)) for crop in chosen[:, 0]])
        return PairBatch(
            photo=to_network(pixels),
            picture=torch.from_numpy(np.stack([self.picture_crop(int(crop)) for crop in chosen[:, 1]])),
            label=torch.from_numpy(self._labels[chosen[:, 0] // self.crops.per_photo]),
        )

    def photo_place(self, crop: int) -> tuple[int, int]:
        """Return top and left of crop ``crop`` in its source, pixels."""
        source, rng = self._photo_draw(crop)
        return self.crops.place(source.rows, source.columns, rng)

    def photo_crop(self, crop: int) -> NDArray[np.uint8]:
        """Return crop ``crop`` of the photographs, uint8, shape (channel, size, size)."""
        source, rng = self._photo_draw(crop)
        return self._cache.get(("photo", crop), lambda: self.crops.random(source.image(), rng))

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
            image: NDArray[np.float32] = self.picture.crop(samples, first - start // self.picture.hop).numpy()
            return image

        return self._cache.get(("picture", crop), make)

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

    Every crop of a material is in each of ``crops.repeats`` random pairings; if one kind has fewer crops, they occur
    about equally often.

    Parameters
    ----------
    examples : sequence of Example, or mapping from str to sequence of Example
        ``source-split``: the examples of the part. The other two protocols leak: they need the examples of all parts by
        name, e.g. ``{"train": …, "validation": …, "test": …}``. Signals have one axis.
    seed : int
        Of crops, augmentation, pairing and order. Leaky protocols need the same for all parts.
    protocol : {"source-split", "crop-split", "pair-then-split"}
        Order of splitting, cutting and pairing.
    part : {"train", "validation", "test"}
        Share of the crops or pairs; without effect for ``source-split``.
    materials : sequence of str, optional
        The classes; by default those of ``examples``, sorted.
    cache_mib : float
        Memory of cached crops, MiB; others are recreated on demand.

    Raises
    ------
    ParameterError
        If an argument is invalid, a material has recordings but no photograph, a photograph is smaller than a crop, a
        recording is shorter than a picture, or a part is empty.
    """
    if protocol not in LEAKS:
        raise ParameterError.one_of("protocol", LEAKS, protocol)
    if part not in SHARES:
        raise ParameterError.one_of("part", SHARES, part)
    if protocol != "source-split" and not isinstance(examples, Mapping):
        raise ParameterError(
            f"protocol {protocol} leaks ({LEAKS[protocol]}): it needs the examples of all parts, by name"
        )
    parts = list(examples.values()) if isinstance(examples, Mapping) else [examples]
    photos, recordings = sources(parts, picture, crops)
    photographed = sorted({source.material for source in photos})
    all_pairs = []
    for name in photographed:
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
        all_pairs.append(pairs)
    return WeakPairs(
        photos,
        recordings,
        np.concatenate(all_pairs),
        picture,
        crops,
        seed=seed,
        materials=photographed if materials is None else materials,
        protocol=protocol,
        cache_mib=cache_mib,
    )


def shuffled(count: int, size: int, number: int, *, seed: int) -> NDArray[np.int64]:
    """Return batch ``number`` of ``size`` out of ``count`` items, each once per epoch, int64, shape (size,).

    Each epoch has another order; a batch may end one epoch and begin the next.
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
    kind: Sequence[PhotoSource | RecordingSource], material: str, count: int
) -> NDArray[np.int64]:
    members = np.array([i for i, source in enumerate(kind) if source.material == material], np.int64)
    return (members[:, None] * count + np.arange(count)).ravel()


def _share(items: NDArray[np.int64], part: Part, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return the share of ``items`` (item, ...) in ``part``, shuffled."""
    begin, end = (round(bound * len(items)) for bound in SHARES[part])
    return rng.permutation(items)[begin:end]


def _pairing(
    photo: NDArray[np.int64], recording: NDArray[np.int64], rng: np.random.Generator
) -> NDArray[np.int64]:
    """Return each crop of the more numerous kind with a random one of the other, shape (pair, 2)."""
    count = max(len(photo), len(recording))
    columns = []
    for crops in (photo, recording):
        rounds = -(-count // len(crops))
        columns.append(np.concatenate([rng.permutation(crops) for _ in range(rounds)])[:count])
    return np.stack(columns, axis=1)


class _ArrayCache:
    """Cache of the last used arrays up to a number of bytes."""

    def __init__(self, most_bytes: int) -> None:
        self._most, self._bytes = most_bytes, 0
        self._arrays: OrderedDict[tuple[str, int], NDArray[Any]] = OrderedDict()

    def get(self, key: tuple[str, int], make: Callable[[], NDArray[Any]]) -> NDArray[Any]:
        if key in self._arrays:
            self._arrays.move_to_end(key)
            return self._arrays[key]
        array = make()
        if array.nbytes <= self._most:
            self._arrays[key] = array
            self._bytes += array.nbytes
        while self._bytes > self._most:
            self._bytes -= self._arrays.popitem(last=False)[1].nbytes
        return array
