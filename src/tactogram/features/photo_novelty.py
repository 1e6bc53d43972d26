"""Novelty of a photograph: its distance to the nearest training photograph, beside the distances between materials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from tactogram.features.photo_descriptor import descriptor
from tactogram.model import Example
from tactogram.signal import Image

UNLIKE = 0.25
"""Novelty from which a photograph counts as unlike all training photographs: the lower quartile, so that about three
quarters of the training photographs would have it, were their own materials left out."""
LEAST_MATERIALS = 3
"""Fewer say too little about the distances between materials."""
LONGEST_SIDE = 512
"""Pixels; of a larger photograph the centre is described, at the same scale."""
LEAST_SPREAD = 1e-9


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
        place = int(distances.argmin())
        return NearestPhotograph(self.materials[place], float((self._to_others < distances[place]).mean()))

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
    found: dict[bytes, Image] = {}
    for photographs in shared.values():
        for k in range(len(photographs)):
            if len(found) == most:
                return list(found.values())
            image = photographs[k]
            found[image.pixels.tobytes()] = image
    return list(found.values())


def _described(image: Image) -> NDArray[np.float64]:
    rows, columns = image.size
    height, width = min(rows, LONGEST_SIDE), min(columns, LONGEST_SIDE)
    top, left = (rows - height) // 2, (columns - width) // 2
    return descriptor(image.cut(top, left, top + height, left + width))
