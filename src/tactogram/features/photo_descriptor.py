"""Photograph descriptor: colour and coarseness, independent of position; and the novelty of a photograph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.model import Example
from tactogram.signal import Image

OCTAVES = 6
"""Octave bands of spatial frequency, from half the sampling rate down."""
DIRECTIONS = 4
"""Orientations of a band's power, sorted, so that turning the camera changes little."""
LUMA = np.array([0.2126, 0.7152, 0.0722])
"""Rec. 709."""
FLOOR = 1e-8
"""Added to powers of contrast, so that a plain surface has a level."""
SMALLEST = 8
"""Pixels of the shorter side."""
UNLIKE = 0.25
"""Novelty from which a photograph counts as unlike all training photographs: the lower quartile, so that about three
quarters of the training photographs would have it, were their own materials left out."""
LEAST_MATERIALS = 3
"""Fewer say too little about the distances between materials."""
LONGEST_SIDE = 512
"""Pixels; of a larger photograph the centre is described, at the same scale."""
LEAST_SPREAD = 1e-9


def check_photograph(image: Any) -> None:
    """Raise `ParameterError` for anything but a photograph that is large enough to be described."""
    if not isinstance(image, Image):
        raise ParameterError(f"condition 'image' must be an Image, got {type(image).__name__}")
    if min(image.size) < SMALLEST:
        raise ParameterError(
            f"a photograph must be at least {SMALLEST} x {SMALLEST} pixels, got {image.size[1]} x {image.size[0]}"
        )


def descriptor(image: Image) -> NDArray[np.float64]:
    """Return colour, contrast and spectrum of a photograph, float64, shape (feature,).

    Mean luminance (0..1), two mean colour differences over it, then 10 log10 of the power of relative contrast in
    octave bands of spatial frequency (per pixel), each in four orientations from weakest to strongest.
    """
    rgb = image.pixels.astype(np.float64) / 255
    luminance = rgb @ LUMA
    mean = luminance.mean()
    colour = (rgb.mean(axis=(0, 1)) - mean)[[0, 2]] / (mean + 1e-3)
    contrast = (luminance - mean) / (mean + 1e-3)
    rows, columns = contrast.shape
    window = np.hanning(rows + 2)[1:-1, None] * np.hanning(columns + 2)[None, 1:-1]
    window /= np.sqrt(np.mean(window**2))
    power = np.abs(np.fft.fft2(contrast * window)) ** 2 / (rows * columns) ** 2
    fy, fx = np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)[None, :]
    radius = np.hypot(fy, fx)
    octave = np.floor(-np.log2(np.maximum(radius, 1e-9) / 0.5)).astype(int)
    sector = np.floor((np.arctan2(fy, fx) % np.pi) / np.pi * DIRECTIONS + 0.5).astype(int) % DIRECTIONS
    levels = [
        sorted(power[(octave == band) & (sector == side)].sum() for side in range(DIRECTIONS))
        for band in range(OCTAVES)
    ]
    return np.concatenate([[mean], colour, 10 * np.log10(np.ravel(levels) + FLOOR)])


class NearestPhotograph(NamedTuple):
    """Nearest training photograph of a photograph."""

    material: str
    novelty: float
    """Share of the training photographs that are nearer to one of another material, 0 to 1."""


@dataclass(frozen=True, eq=False)
class PhotoNovelty:
    """Training photographs of several materials, described.

    Parameters
    ----------
    materials : tuple of str
        Material of each photograph.
    descriptors : float64 array, shape (photograph, feature)
        As of `tactogram.features.photo_descriptor.descriptor`.
    """

    materials: tuple[str, ...]
    descriptors: NDArray[np.float64]

    @classmethod
    def of(cls, photographs: Mapping[str, Sequence[Image]]) -> Self | None:
        """Return those of ``photographs``, by material; None if there are fewer than `LEAST_MATERIALS`."""
        shown = [(name, image) for name, images in photographs.items() for image in images]
        if len({name for name, _ in shown}) < LEAST_MATERIALS:
            return None
        return cls(tuple(name for name, _ in shown), np.array([_described(image) for _, image in shown]))

    def nearest(self, image: Image) -> NearestPhotograph:
        """Return the material of the nearest training photograph, and the novelty of ``image``."""
        distances = self._distances(_described(image))
        index = int(distances.argmin())
        return NearestPhotograph(self.materials[index], float((self._to_others < distances[index]).mean()))

    @cached_property
    def _to_others(self) -> NDArray[np.float64]:
        """Distance of each training photograph to the nearest of another material, shape (photograph,)."""
        names = np.array(self.materials)
        return np.array(
            [
                self._distances(row)[names != name].min()
                for row, name in zip(self.descriptors, names, strict=True)
            ]
        )

    def _distances(self, described: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return distances to all training photographs; each feature counts by its spread over them."""
        spread = self.descriptors.std(axis=0)
        spread[spread < LEAST_SPREAD] = 1.0
        return np.asarray(np.linalg.norm((self.descriptors - described) / spread, axis=1))

    def facts(self) -> dict[str, Any]:
        """Return the photographs as JSON values."""
        return {"materials": list(self.materials), "descriptors": self.descriptors.round(4).tolist()}

    @classmethod
    def from_facts(cls, facts: Mapping[str, Any]) -> Self:
        """Return the photographs of `facts`; raises `KeyError`, `TypeError` or `ValueError` for others."""
        materials = tuple(map(str, facts["materials"]))
        return cls(materials, np.array(facts["descriptors"], np.float64).reshape(len(materials), -1))


def distinct_photographs(examples: Sequence[Example], most: int) -> list[Image]:
    """Return up to ``most`` photographs of examples, which many of them may share."""
    shared = {id(example.photographs): example.photographs for example in examples}
    images: dict[bytes, Image] = {}
    for photographs in shared.values():
        for k in range(len(photographs)):
            if len(images) == most:
                return list(images.values())
            image = photographs[k]
            images[image.pixels.tobytes()] = image
    return list(images.values())


def _described(image: Image) -> NDArray[np.float64]:
    rows, columns = image.size
    height, width = min(rows, LONGEST_SIDE), min(columns, LONGEST_SIDE)
    top, left = (rows - height) // 2, (columns - width) // 2
    return descriptor(image.cut(top, left, top + height, left + width))
