"""Keep recordings in one step; generate by joining random segments of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.model import (
    Condition,
    Example,
    SignalKind,
    Stage,
    check_condition,
    material_weights,
)
from tactogram.models.replay.config import Config
from tactogram.signal import Signal
from tactogram.signal.concatenative import concatenated, excerpts
from tactogram.training.seeds import child_rng

if TYPE_CHECKING:
    import torch

NAMES = ("speed_mm_s", "force_n")
SHORTEST_JUDGED_S = 0.25
"""Shorter recordings have no log-spectral distance."""


@dataclass(frozen=True, eq=False)
class StoredSegment:
    """A stretch of a training recording, and what it was recorded under."""

    id: str
    signal: Signal
    condition: Mapping[str, float | None]


class ReplayLearner:
    """The recordings themselves, per material.

    Parameters
    ----------
    config : Config
    kind : SignalKind
        Rate, unit, axes and materials of the training signals.
    seed : int
        Decides which stretch of a recording is kept.
    """

    def __init__(self, config: Config, kind: SignalKind, *, seed: int) -> None:
        if not kind.materials:
            raise ParameterError("replay needs recordings with a material, got none")
        self.config = config
        self.kind = kind
        self.materials = kind.materials
        self.seed = seed
        self.kept: dict[str, list[StoredSegment]] = {}
        self.seconds = 0.0

    def setup(self, fabric: Any) -> None:
        """Nothing to hand over: there are no weights."""

    # -- training ----------------------------------------------------------------------------------------

    def stages(self, examples: Sequence[Example]) -> tuple[Stage, ...]:
        return (Stage("keep", 1),)

    def batches(
        self, stage: Stage, examples: Sequence[Example], *, seed: int, start: int = 0
    ) -> Iterator[Any]:
        if start == 0:
            yield examples

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        examples: Sequence[Example] = batch
        found = self.kind.by_material(examples)
        for example in examples:
            if len(example.signal) <= 2 * self._least:
                raise ParameterError(
                    f"recording {example.id} must be longer than {2 * self._least} samples, two crossfades "
                    f"and searches; got {len(example.signal)}: lower config.overlap_s"
                )
        self.kept = {name: self._keep(name, members) for name, members in found.items()}
        self.seconds = float(np.median([example.signal.extent for example in examples]))
        kept = [sum(k.signal.extent for k in members) for members in self.kept.values()]
        return {"seconds_per_material": float(np.mean(kept))}

    @property
    def _least(self) -> int:
        """Samples that a crossfade and the search before it use."""
        return round(self.config.overlap_s * self.kind.rate) + round(self.config.search_s * self.kind.rate)

    def _keep(self, material: str, examples: Sequence[Example]) -> list[StoredSegment]:
        """Return a stretch of each of ``examples``, or of as many, drawn, as a segment each leaves room for."""
        budget, segment = (
            max(1, round(s * self.kind.rate))
            for s in (self.config.seconds_per_material, self.config.segment_s)
        )
        kept = excerpts(
            [example.signal for example in examples],
            budget,
            segment=segment,
            least=2 * self._least + 1,
            rng=child_rng(self.seed, "keep", material),
        )
        return [
            StoredSegment(
                examples[i].id, cut, {name: _number(examples[i].condition.get(name)) for name in NAMES}
            )
            for i, cut in kept
        ]

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return ``log_spectral_distance_db`` from unseen recordings to replayed ones of the same length."""
        distances = []
        for number, example in enumerate(examples):
            over_time = self.kind.domain == "time"
            if example.material in self.kept and over_time and example.signal.seconds >= SHORTEST_JUDGED_S:
                made = self.generate(
                    {"material": example.material}, seconds=example.signal.seconds, seed=number
                )
                distances.append(log_spectral_distance([made], [example.signal]))
        return {"log_spectral_distance_db": float(np.mean(distances))} if distances else {}

    def state(self) -> dict[str, Any]:
        return {
            "seconds": self.seconds,
            "materials": {
                name: [
                    {"id": k.id, "samples": k.signal.samples, "condition": dict(k.condition)} for k in members
                ]
                for name, members in self.kept.items()
            },
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        if state["materials"] and tuple(state["materials"]) != self.materials:
            raise ParameterError(
                f"state is of {', '.join(state['materials'])}; expected {', '.join(self.materials)}"
            )
        self.seconds = float(state["seconds"])
        self.kept = {
            name: [StoredSegment(k["id"], self._signal(k["samples"]), k["condition"]) for k in members]
            for name, members in state["materials"].items()
        }

    def _signal(self, samples: Any) -> Signal:
        return Signal(np.asarray(samples), self.kind.rate, self.kind.unit, self.kind.axes, self.kind.domain)

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        check_condition(condition, needs=("material",), takes=NAMES)
        weights = material_weights(condition, self.materials)
        if not self.kept:
            raise ParameterError("replay has not been trained")
        seconds = self.seconds if seconds is None else seconds
        mixed = 0.0
        for name, weight in zip(self.materials, weights / weights.sum(), strict=True):
            if weight > 0:
                members = self._nearest(name, condition)
                x = self._replayed(members, seconds, seed, name).samples.astype(np.float64)
                # Gravity and the like, the same in all, mixes evenly; vibrations, which are not, by power.
                steady = np.mean([k.signal.samples.mean(axis=1, keepdims=True) for k in members], axis=0)
                mixed = mixed + weight * steady + np.sqrt(weight) * (x - steady)
        return self._signal(np.float32(mixed))

    def _replayed(self, members: Sequence[StoredSegment], seconds: float, seed: int, name: str) -> Signal:
        return concatenated(
            [k.signal for k in members],
            seconds=seconds,
            segment=max(1, round(self.config.segment_s * self.kind.rate)),
            overlap_s=self.config.overlap_s,
            search_s=self.config.search_s,
            rng=lambda number: child_rng(seed, "replay", name, number),
        )

    def _nearest(self, name: str, condition: Condition) -> list[StoredSegment]:
        """Return the recordings whose speed and force are nearest to what is asked for; all, if nothing is.

        Distance: Euclidean, each quantity as a share of what the material's recordings span.
        """
        members = self.kept[name]
        distance = np.zeros(len(members))
        for quantity in NAMES:
            asked = condition.get(quantity)
            if asked is None:
                continue
            if not (np.isfinite(asked) and asked >= 0):
                raise ParameterError(f"{quantity} must be finite and >= 0, got {asked}")
            known = np.array([k.condition[quantity] for k in members], dtype=np.float64)  # None: nan
            if np.isnan(known).all():
                raise ParameterError(f"{quantity} is not known of the recordings of {name}; leave it out")
            span = np.nanmax(known) - np.nanmin(known)
            distance += np.nan_to_num((known - asked) / (span or 1.0), nan=np.inf) ** 2
        if not np.isfinite(distance).any():
            raise ParameterError(
                f"no recording of {name} names both {' and '.join(NAMES)}; leave one of them out"
            )
        return [k for k, far in zip(members, distance, strict=True) if far <= distance.min() + 1e-12]


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> ReplayLearner:
    """Return a model that holds nothing yet; it always computes on the processor."""
    return ReplayLearner(config, kind, seed=seed)


def _number(value: Any) -> float | None:
    return None if value is None else float(value)
