"""Storage of recordings in one step; generation by joining random segments of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.model import (
    Condition,
    Example,
    Limit,
    Model,
    ModelConfig,
    SignalKind,
    Stage,
    check_condition,
    check_state,
    limits_within,
    material_weights,
)
from tactogram.signal import Signal
from tactogram.signal.joining import concatenated, excerpts
from tactogram.training.seeds import child_rng


class Config(ModelConfig):
    """Stored part of the recordings, and joins of segments. All of it is ours: the method has no single publication."""

    seconds_per_material: float = Field(default=60.0, gt=0, allow_inf_nan=False)
    """Most of each material's recordings that is stored, s, divided evenly among them; bounds the run's size."""
    segment_s: float = Field(default=0.5, gt=0, allow_inf_nan=False)
    """Length of the segments that are joined, s, crossfades included; a shorter recording is one segment."""
    overlap_s: float = Field(default=0.1, ge=0, allow_inf_nan=False)
    """Length of the crossfades, s."""
    search_s: float = Field(default=0.02, ge=0, allow_inf_nan=False)
    """How far a segment may move for the smoothest join, s (Verhelst & Roelands 1993)."""

    @model_validator(mode="after")
    def _segments_outlast_crossfades(self) -> Self:
        if self.segment_s <= 2 * self.overlap_s + self.search_s:
            raise ValueError(
                f"segment_s must be above 2 overlap_s + search_s, {2 * self.overlap_s + self.search_s:g} s"
            )
        return self


NAMES = ("speed_mm_s", "force_n")
SHORTEST_EVALUATED_S = 0.25
"""Shorter recordings have no log-spectral distance."""


@dataclass(frozen=True, eq=False)
class StoredSegment:
    """A segment of a training recording, with its speed and force."""

    id: str
    signal: Signal
    condition: Mapping[str, float | None]


class ReplayLearner(Model):
    """Segments of the recordings by material; ``seed`` decides which segments."""

    config: Config
    kind: SignalKind

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.kind.require_materials("replay")
        self.segments: dict[str, list[StoredSegment]] = {}
        self.seconds = 0.0

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        examples: Sequence[Example] = batch
        by_material = self.kind.by_material(examples)
        for example in examples:
            if len(example.signal) <= 2 * self._join:
                raise ParameterError(
                    f"recording {example.id} must be longer than {2 * self._join} samples, two crossfades "
                    f"and searches; got {len(example.signal)}: lower config.overlap_s"
                )
        self.segments = {name: self._stored(name, members) for name, members in by_material.items()}
        self.seconds = float(np.median([example.signal.extent for example in examples]))
        stored = [sum(s.signal.extent for s in members) for members in self.segments.values()]
        return {"seconds_per_material": float(np.mean(stored))}

    @property
    def _join(self) -> int:
        """Samples of a crossfade and the search before it."""
        return round(self.config.overlap_s * self.kind.rate) + round(self.config.search_s * self.kind.rate)

    def _stored(self, material: str, examples: Sequence[Example]) -> list[StoredSegment]:
        """Return a segment of each of ``examples``, or of as many, drawn, as the configured duration allows."""
        budget, segment = (
            max(1, round(s * self.kind.rate))
            for s in (self.config.seconds_per_material, self.config.segment_s)
        )
        stored = excerpts(
            [example.signal for example in examples],
            budget,
            segment=segment,
            least=2 * self._join + 1,
            rng=child_rng(self.seed, "keep", material),
        )
        return [
            StoredSegment(
                examples[i].id, cut, {name: _number(examples[i].condition.get(name)) for name in NAMES}
            )
            for i, cut in stored
        ]

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return ``log_spectral_distance_db`` from unseen recordings to replayed ones of the same length."""
        distances = []
        for number, example in enumerate(examples):
            over_time = self.kind.domain == "time"
            if (
                example.material in self.segments
                and over_time
                and example.signal.seconds >= SHORTEST_EVALUATED_S
            ):
                generated = self.generate(
                    {"material": example.material}, seconds=example.signal.seconds, seed=number
                )
                distances.append(log_spectral_distance([generated], [example.signal]))
        return {"log_spectral_distance_db": float(np.mean(distances))} if distances else {}

    def state(self) -> dict[str, Any]:
        return {
            "seconds": self.seconds,
            "materials": {
                name: [
                    {"id": s.id, "samples": s.signal.samples, "condition": dict(s.condition)} for s in members
                ]
                for name, members in self.segments.items()
            },
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        check_state(tuple(state["materials"]) or self.materials, self.materials)
        self.seconds = float(state["seconds"])
        self.segments = {
            name: [StoredSegment(s["id"], self.kind.signal(s["samples"]), s["condition"]) for s in members]
            for name, members in state["materials"].items()
        }

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        check_condition(condition, needs=("material",), takes=NAMES)
        weights = material_weights(condition, self.materials)
        if not self.segments:
            raise ParameterError("replay has not been trained")
        seconds = self.seconds if seconds is None else seconds
        mixed = 0.0
        for name, weight in zip(self.materials, weights / weights.sum(), strict=True):
            if weight > 0:
                members = self._nearest(name, condition)
                x = self._replayed(members, seconds, seed, name).samples.astype(np.float64)
                # Constant parts, as gravity, add linearly; vibrations, which are independent, add by power.
                steady = np.mean([s.signal.samples.mean(axis=1, keepdims=True) for s in members], axis=0)
                mixed = mixed + weight * steady + np.sqrt(weight) * (x - steady)
        return self.kind.signal(np.float32(mixed))

    def limits(self, condition: Condition) -> list[Limit]:
        limits: list[Limit] = []
        for index in np.flatnonzero(material_weights(condition, self.materials)).tolist():
            used = self._nearest(self.materials[index], condition)[0].condition
            ranges = {name: (value, value) for name, value in used.items() if value is not None}
            limits += limits_within(condition, ranges, f"of {self.materials[index]}")
        return limits

    def _replayed(self, members: Sequence[StoredSegment], seconds: float, seed: int, name: str) -> Signal:
        return concatenated(
            [s.signal for s in members],
            seconds=seconds,
            segment=max(1, round(self.config.segment_s * self.kind.rate)),
            overlap_s=self.config.overlap_s,
            search_s=self.config.search_s,
            rng=lambda number: child_rng(seed, "replay", name, number),
        )

    def _nearest(self, name: str, condition: Condition) -> list[StoredSegment]:
        """Return the segments nearest to the speed and force of ``condition``; all, if it has neither.

        Distance: Euclidean, each quantity as a share of the range of the material's recordings.
        """
        members = self.segments[name]
        distance = np.zeros(len(members))
        for quantity in NAMES:
            value = condition.get(quantity)
            if value is None:
                continue
            if not (np.isfinite(value) and value >= 0):
                raise ParameterError(f"{quantity} must be finite and >= 0, got {value}")
            values = np.array([s.condition[quantity] for s in members], dtype=np.float64)  # None: nan
            if np.isnan(values).all():
                raise ParameterError(f"{quantity} is unknown for the recordings of {name}; omit it")
            span = np.nanmax(values) - np.nanmin(values)
            distance += np.nan_to_num((values - value) / (span or 1.0), nan=np.inf) ** 2
        if not np.isfinite(distance).any():
            raise ParameterError(f"no recording of {name} has both {' and '.join(NAMES)}; omit one of them")
        return [s for s, far in zip(members, distance, strict=True) if far <= distance.min() + 1e-12]


build = ReplayLearner


def _number(value: Any) -> float | None:
    return None if value is None else float(value)
