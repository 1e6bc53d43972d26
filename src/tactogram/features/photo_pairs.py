"""Weak pairs of photograph and spectrogram picture: two things of one material that were never registered."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.model import Example
from tactogram.signal import Image

Protocol = Literal["source-split", "crop-split", "pair-then-split"]
Part = Literal["train", "validation", "test"]


@dataclass(frozen=True, kw_only=True)
class PhotoCrops:
    """How photographs and recordings are cut and paired; defaults are the paper's (Neshov et al. 2026, Sec. 4.1).

    Parameters
    ----------
    crop : int, pixels
        Side of the square that is cut from a photograph.
    size : int, pixels
        Side of what the network gets: ``crop`` averaged down where it is smaller.
    grayscale : bool
        One channel (ITU-R 601 luma), or three.
    per_photo, per_recording : int
        Random crops of each photograph, and of each recording.
    repeats : int
        How often all crops of a material are paired anew.
    flips : bool
        Left to right and top to bottom, each with probability 1/2.
    brightness, contrast : float, 0..1
        Each by a factor drawn evenly from 1 - x to 1 + x. The paper names no amount.
    """

    crop: int = 256
    size: int = 256
    grayscale: bool = True
    per_photo: int = 10
    per_recording: int = 10
    repeats: int = 10
    flips: bool = True
    brightness: float = 0.2
    contrast: float = 0.2

    @property
    def channels(self) -> int:
        """1 or 3."""
        return 1 if self.grayscale else 3

    def centre(self, image: Image) -> Tensor:
        """Return the middle of a photograph, not augmented, float32, shape (channel, size, size), in [-1, 1]."""
        raise NotImplementedError


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
        The photograph of each pair.
    """

    photo: Tensor
    picture: Tensor
    label: Tensor
    ids: tuple[str, ...]
    photos: tuple[str, ...]

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.label)


class WeakPairs:
    """Pairs by number. Made by `weak_pairs`; nothing is decoded before it is asked for."""

    materials: tuple[str, ...]
    protocol: Protocol
    leaks: str

    def __len__(self) -> int:
        """Return the number of pairs."""
        raise NotImplementedError

    def batch(self, places: Sequence[int] | NDArray[np.int64]) -> PairBatch:
        """Return the pairs at ``places``; pair i is the same however it is asked for."""
        raise NotImplementedError

    def places(self, number: int, size: int) -> NDArray[np.int64]:
        """Return the places of batch ``number``: every pair once per epoch, in an order of its own.

        Depends on the seed, ``number`` and ``size`` alone.
        """
        raise NotImplementedError

    def batches(self, size: int, *, start: int = 0) -> Iterator[PairBatch]:
        """Yield batches of ``size`` pairs from number ``start`` on, without end."""
        raise NotImplementedError


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

    Parameters
    ----------
    examples : sequence of Example, or mapping from str to such
        ``source-split``: the examples of the part. The other two leak; they need those of all parts, by name.
    picture : SpectrogramPicture
    crops : PhotoCrops
    seed : int
        Of crops, augmentation, pairing and order.
    protocol : {"source-split", "crop-split", "pair-then-split"}
        What is split before what.
    part : {"train", "validation", "test"}
        Which share of crops or pairs; of no effect with ``source-split``.
    materials : sequence of str, optional
        The classes; by default those of ``examples``, sorted.
    cache_mib : float
        How much memory decoded photographs and finished crops may take, MiB.
    """
    raise NotImplementedError
