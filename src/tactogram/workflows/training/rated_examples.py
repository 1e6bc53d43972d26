"""Examples with ratings: rated signals, rated images, or rated surfaces with rated signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from tactogram.datasets import (
    Examples,
    PhotographRegions,
    Ratings,
    RecordingInfo,
    Region,
    Segment,
    Split,
    Store,
    item_of,
    signal_kind,
    split_fractions,
)
from tactogram.datasets.splits.split import By
from tactogram.errors import ParameterError
from tactogram.model import Example, ImageExample, ImageKind, Kind
from tactogram.models import LearnsFrom
from tactogram.recipe import Preparation

TEST_SHARE, VALIDATION_SHARE = 0.2, 0.1
"""Shares of the recordings that `train` keeps for `evaluate`, and for selection and calibration."""


@dataclass(frozen=True)
class RatingData:
    """A store for the training of a model on ratings.

    ``learns_from`` is ``ratings``: of signals, or of images if the store has no recordings; ``images``; or ``both``:
    recordings of rated surfaces, and rated signals that are of no material.
    """

    store: Store
    learns_from: LearnsFrom

    @property
    def ratings(self) -> Ratings:
        """The ratings; refuses a store that has none."""
        if self.store.ratings is None:
            raise ParameterError(
                f"{self.store.path}: has no ratings; `tactogram data rate` adds a table of them"
            )
        return self.store.ratings

    @property
    def of_images(self) -> bool:
        """Whether the examples are images."""
        return self.learns_from == "images" or (self.learns_from == "ratings" and not len(self.store))

    def split(
        self, index: Sequence[RecordingInfo], prepare: Preparation, *, split: str, by: By, seed: int
    ) -> Split:
        """Return parts of different items; for ``both``, surfaces split ``by``, and all rated signals in ``train``."""
        if split not in ("", "all"):
            raise ParameterError.must(
                "split", f"be all, or omitted, for a model that learns from ratings; got {split!r}"
            )
        if self.of_images:
            return self._split_images(everything=split == "all", seed=seed)
        rated = set(self.ratings.items)
        held = [info for info in index if item_of(info) in rated and self._has_stream(info, prepare)]
        if not held and self.learns_from == "ratings":
            stream = f" has the stream {prepare.stream!r} and" if prepare.stream else ""
            raise ParameterError(f"{self.store.path}: none of its recordings{stream} was rated")
        if self.learns_from == "ratings":
            parts = _parts(held, by="material", everything=split == "all", seed=seed, nameless=True)
        else:
            surfaces = [info for info in held if info.material is not None]
            signals = tuple(Segment(info.id) for info in held if info.material is None)
            if not surfaces or not signals:
                raise ParameterError(
                    f"{self.store.path}: must hold rated surfaces and rated signals without a material, got "
                    f"{len(surfaces)} and {len(signals)}"
                )
            parts = _parts(surfaces, by=by, everything=split == "all", seed=seed)
            parts = Split(
                parts.train + signals, parts.validation, parts.test, parts.by, parts.seed, groups=parts.groups
            )
        return parts

    def examples(self, split: Split, part: str, prepare: Preparation) -> Sequence[Any]:
        """Return one part of ``split``: of `Example`, or of `ImageExample` if the examples are images."""
        if not self.of_images:
            return Examples(self.store, split.parts[part], prepare)
        names = {key: item for item, keys in self.store.photographs_by_material.items() for key in keys}
        return [
            ImageExample(
                region.key,
                PhotographRegions(self.store, (region,)),
                names[region.key],
                self.ratings.rated(names[region.key]),
            )
            for region in split.photographs.get(part, ())
        ]

    def kind(self, examples: Sequence[Example] | Sequence[ImageExample]) -> Kind:
        """Return the kind of all examples; for ``both``, that of the rated signals, which such a model generates."""
        ratings = self.ratings
        scale = (ratings.scale.low, ratings.scale.high)
        if self.of_images:
            items = tuple(sorted({example.item for example in examples if example.item}))
            return ImageKind(ratings.words, scale, items, self.store.simulated)
        recorded = [example for example in examples if isinstance(example, Example)]
        sided = [e for e in recorded if e.material is None] if self.learns_from == "both" else recorded
        kind = signal_kind(sided, simulated=self.store.simulated)
        materials = tuple(sorted({e.material for e in recorded if e.material is not None}))
        return replace(kind, words=ratings.words, scale=scale, materials=materials)

    def _has_stream(self, info: RecordingInfo, prepare: Preparation) -> bool:
        return prepare.stream is None or prepare.stream in self.store.streams_of(info.id)

    def _split_images(self, *, everything: bool, seed: int) -> Split:
        rated = set(self.ratings.items)
        keys = self.store.photographs_by_material
        infos = [RecordingInfo(id=key, material=item) for item in keys if item in rated for key in keys[item]]
        if not infos:
            raise ParameterError(f"{self.store.path}: none of its photographs was rated")
        parts = _parts(infos, by="material", everything=everything, seed=seed)
        regions = {part: tuple(Region(segment.id) for segment in held) for part, held in parts.parts.items()}
        return Split((), (), (), by="material", seed=seed, photographs=regions)


def _parts(
    infos: Sequence[RecordingInfo], *, by: By, everything: bool, seed: int, nameless: bool = False
) -> Split:
    if everything:
        return Split(tuple(Segment(info.id) for info in infos), (), (), by=by, seed=seed)
    if nameless:
        infos = [replace(info, material=item_of(info)) for info in infos]
    return split_fractions(infos, by=by, test=TEST_SHARE, validation=VALIDATION_SHARE, seed=seed)
