"""Sources of weak pairs: photographs and recordings, read on demand."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.examples import Examples, require_photographs
from tactogram.datasets.splits.photograph_splitting import PhotographRegions
from tactogram.datasets.store.photographs import image_key
from tactogram.errors import ParameterError
from tactogram.features.photo_crops import PhotoCrops
from tactogram.features.spectrogram_picture import SpectrogramPicture
from tactogram.model import Example
from tactogram.signal import Image

Box = tuple[int, int, int, int]
"""Top, left, rows and columns, pixels."""


@dataclass(frozen=True)
class PhotoSource:
    """The photograph ``photographs[place]``, or its region that a part of a split may use.

    All regions of a photograph have one ``key``.
    """

    key: str
    top: int
    left: int
    rows: int
    columns: int
    material: str
    photographs: Sequence[Image] = field(repr=False, compare=False)
    place: int = field(repr=False, compare=False)

    def image(self) -> Image:
        """Return its pixels, decoded now."""
        return self.photographs[self.place]


@dataclass(frozen=True)
class RecordingSource:
    """The recording ``examples[example].signal``, or its segment that a part of a split may use, in samples.

    All segments of a recording have one ``id``.
    """

    id: str
    start: int
    length: int
    material: str
    examples: Sequence[Example] = field(repr=False, compare=False)
    example: int = field(repr=False, compare=False)

    def samples(self) -> NDArray[np.float32]:
        """Return its samples, float32, shape (time,), read now."""
        samples: NDArray[np.float32] = self.examples[self.example].signal.samples[0]
        return samples


def sources(
    parts: Sequence[Sequence[Example]], picture: SpectrogramPicture, crops: PhotoCrops
) -> tuple[tuple[PhotoSource, ...], tuple[RecordingSource, ...]]:
    """Return the photographs (for each material they show) and recordings of examples, each once, in their order.

    Refused: a material without photographs, an example without material or with several axes, a signal with another
    rate, unit or domain than the picture, and anything too small to be cut.
    """
    photos: dict[tuple[str, Box, str], PhotoSource] = {}
    recordings = []
    # Many recordings of a material share its photographs, which are listed once.
    listed: dict[object, Sequence[Image]] = {}
    for examples in parts:
        require_photographs(examples)
        for number, example in enumerate(examples):
            if example.material is None:
                raise ParameterError(f"recording {example.id} has no material; pairs need one")
            signal = example.signal
            if len(signal.axes) != 1:
                raise ParameterError(
                    f"a picture has one axis, got {','.join(signal.axes)}: set prepare.axes=['{signal.axes[-1]}']"
                )
            picture.spectrogram.check_signal(signal)
            picture.places(len(signal))
            start = _start(examples, number, signal.rate)
            recordings.append(
                RecordingSource(example.id, start, len(signal), example.material, examples, number)
            )
            shared = _identity(example.photographs)
            if (shared, example.material) in listed:
                continue
            listed[shared, example.material] = example.photographs
            for index, (key, box) in enumerate(_boxes(example.photographs)):
                if (key, box, example.material) not in photos:
                    crops.check(*box[2:])
                    photos[key, box, example.material] = PhotoSource(
                        key, *box, example.material, example.photographs, index
                    )
    return tuple(photos.values()), tuple(recordings)


def _identity(photographs: Sequence[Image]) -> object:
    """Return a key that sequences of the same photographs share, as far as visible without decoding."""
    if isinstance(photographs, PhotographRegions):
        return id(photographs.store), photographs.regions
    return id(photographs)


def _boxes(photographs: Sequence[Image]) -> Iterator[tuple[str, Box]]:
    """Yield key and box of each photograph or region; those in a store are not decoded."""
    if isinstance(photographs, PhotographRegions):
        for region in photographs.regions:
            rows, columns = photographs.store.photograph_size(region.key)
            bottom = rows if region.bottom is None else min(region.bottom, rows)
            right = columns if region.right is None else min(region.right, columns)
            yield region.key, (region.top, region.left, bottom - region.top, right - region.left)
    else:
        for image in photographs:
            rows, columns = image.pixels.shape[:2]
            yield image_key(image), (0, 0, rows, columns)


def _start(examples: Sequence[Example], number: int, rate: float) -> int:
    """Return the first sample of an example in its recording; 0 if unknown."""
    return round(examples.segments[number].start_s * rate) if isinstance(examples, Examples) else 0
