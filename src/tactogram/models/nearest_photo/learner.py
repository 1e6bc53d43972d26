"""Storage of described photographs and recordings in one step; generation from those of the nearest photograph."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.features.photo_descriptor import check_photograph, descriptor
from tactogram.model import (
    Condition,
    Example,
    Model,
    ModelConfig,
    SignalKind,
    Stage,
    check_condition,
    check_state,
)
from tactogram.signal import Image, Signal
from tactogram.signal.joining import concatenated, excerpts
from tactogram.training.seeds import child_rng


class Config(ModelConfig):
    """Stored photographs and recordings, and comparison of photographs. All of it is ours."""

    photographs: int = Field(default=50, gt=0)
    """Most photographs stored of each material."""
    neighbours: int = Field(default=1, gt=0)
    """Photographs that vote, nearest first; ties go to the nearer."""
    seconds_per_material: float = Field(default=60.0, gt=0, allow_inf_nan=False)
    """Most of each material's recordings that is stored, s (mm over displacement)."""
    segment_s: float = Field(default=0.5, gt=0, allow_inf_nan=False)
    """Length of the segments that are joined, s (mm over displacement)."""
    overlap_s: float = Field(default=0.1, ge=0, allow_inf_nan=False)
    """Length of the crossfades, s (mm over displacement)."""
    search_s: float = Field(default=0.02, ge=0, allow_inf_nan=False)
    """How far a segment may move for the smoothest join, s (mm over displacement)."""


SHORTEST_EVALUATED_S = 0.25
"""Shorter recordings have no log-spectral distance."""


class NearestPhotoLearner(Model):
    """Descriptors of photographs, and recordings of the materials they show; ``seed`` decides which are stored."""

    config: Config
    kind: SignalKind
    saved = ("seconds", "described=descriptors", "shown=labels")

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.kind.require_materials("nearest_photo")
        self.recordings: dict[str, list[Signal]] = {}
        self.descriptors = np.empty((0, 0))
        self.labels: list[str] = []
        """Material of each row of `descriptors`."""
        self.seconds = 0.0

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        examples: Sequence[Example] = batch
        by_material = self.kind.by_material(examples)
        descriptors = {name: self._descriptors(name, members) for name, members in by_material.items()}
        if missing := [name for name, rows in descriptors.items() if not rows]:
            raise ParameterError(
                f"no photograph of {', '.join(missing)} to compare with: import photographs of these materials, or "
                "omit their recordings"
            )
        self.labels = [name for name, rows in descriptors.items() for _ in rows]
        self.descriptors = np.array([row for rows in descriptors.values() for row in rows])
        self.recordings = {name: self._stored(name, members) for name, members in by_material.items()}
        self.seconds = float(np.median([example.signal.extent for example in examples]))
        return {"photographs_per_material": len(self.labels) / len(self.materials)}

    def _descriptors(self, material: str, examples: Sequence[Example]) -> list[NDArray[np.float64]]:
        """Return the distinct descriptors of a material's photographs, which many examples may share."""
        shared = {id(e.photographs): e.photographs for e in examples if len(e.photographs)}
        places = [(photographs, k) for photographs in shared.values() for k in range(len(photographs))]
        drawn = child_rng(self.seed, "photographs", material).permutation(len(places))
        rows: dict[bytes, NDArray[np.float64]] = {}
        for index in drawn[: self.config.photographs]:
            photographs, k = places[index]
            row = _descriptor(photographs[k])
            rows[row.tobytes()] = row
        return list(rows.values())

    def _stored(self, material: str, examples: Sequence[Example]) -> list[Signal]:
        budget = max(1, round(self.config.seconds_per_material * self.kind.rate))
        rng = child_rng(self.seed, "keep", material)
        signals = [example.signal for example in examples]
        # Two crossfades and searches, and a sample.
        least = 2 * round((self.config.overlap_s + self.config.search_s) * self.kind.rate) + 1
        return [s for _, s in excerpts(signals, budget, segment=self._segment, least=least, rng=rng)]

    @property
    def _segment(self) -> int:
        return max(1, round(self.config.segment_s * self.kind.rate))

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return the accuracy of unseen photographs, and the distance of their signals from the recordings."""
        correct: list[float] = []
        distances: list[float] = []
        for number, example in enumerate(examples):
            if example.material in self.materials:
                correct.extend(self.material_of(image) == example.material for image in example.photographs)
            over_time = self.kind.domain == "time"
            if len(example.photographs) and over_time and example.signal.seconds >= SHORTEST_EVALUATED_S:
                generated = self.generate(
                    {"image": example.photographs[0]}, seconds=example.signal.seconds, seed=number
                )
                distances.append(log_spectral_distance([generated], [example.signal]))
        figures = {"photograph_accuracy": correct, "log_spectral_distance_db": distances}
        return {name: float(np.mean(values)) for name, values in figures.items() if values}

    def state(self) -> dict[str, Any]:
        recordings = {name: [s.samples for s in stored] for name, stored in self.recordings.items()}
        return super().state() | {"recordings": recordings}

    def load_state(self, state: Mapping[str, Any]) -> None:
        check_state(tuple(state["recordings"]) or self.materials, self.materials)
        super().load_state(state)
        self.recordings = {
            name: [self.kind.signal(samples) for samples in stored]
            for name, stored in state["recordings"].items()
        }

    def classify_photograph(self, image: Image) -> tuple[str, None]:
        return self.material_of(image), None

    def material_of(self, image: Image) -> str:
        """Return the material of the nearest photographs; each feature counts by its spread over those stored."""
        if not self.labels:
            raise ParameterError("nearest_photo has not been trained")
        spread = self.descriptors.std(axis=0)
        spread[spread < 1e-9] = 1.0
        distances = np.linalg.norm((self.descriptors - _descriptor(image)) / spread, axis=1)
        nearest = [self.labels[k] for k in np.argsort(distances, kind="stable")[: self.config.neighbours]]
        return str(Counter(nearest).most_common(1)[0][0])

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        check_condition(condition, needs=("image",))
        material = self.material_of(condition["image"])
        return concatenated(
            self.recordings[material],
            seconds=self.seconds if seconds is None else seconds,
            segment=self._segment,
            overlap_s=self.config.overlap_s,
            search_s=self.config.search_s,
            rng=lambda number: child_rng(seed, "nearest_photo", material, number),
        )


build = NearestPhotoLearner


def _descriptor(image: Any) -> NDArray[np.float64]:
    check_photograph(image)
    return descriptor(image)
