"""Describe photographs and keep recordings in one step; generate what was recorded where the nearest was taken."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.features.photo_descriptor import SMALLEST, descriptor
from tactogram.model import Condition, Example, SignalKind, Stage, check_condition
from tactogram.models.nearest_photo.config import Config
from tactogram.signal import Image, Signal
from tactogram.signal.concatenative import concatenated, excerpts
from tactogram.training.seeds import child_rng

if TYPE_CHECKING:
    import torch

SHORTEST_JUDGED_S = 0.25
"""Shorter recordings have no log-spectral distance."""


class NearestPhotoLearner:
    """Photographs, described, and the recordings of the materials they show.

    Parameters
    ----------
    config : Config
    kind : SignalKind
        Rate, unit, axes and materials of the training signals.
    seed : int
        Decides which stretch of a recording, and which photographs, are kept.
    """

    def __init__(self, config: Config, kind: SignalKind, *, seed: int) -> None:
        if not kind.materials:
            raise ParameterError("nearest_photo needs recordings with a material, got none")
        self.config, self.kind, self.seed = config, kind, seed
        self.materials = kind.materials
        self.kept: dict[str, list[Signal]] = {}
        self.described = np.empty((0, 0))
        self.shown: list[str] = []
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
        described = {name: self._describe(name, members) for name, members in found.items()}
        if missing := [name for name, rows in described.items() if not rows]:
            raise ParameterError(
                f"no photograph of {', '.join(missing)} to compare with: import photographs of these materials, or "
                "leave them out with --where"
            )
        self.shown = [name for name, rows in described.items() for _ in rows]
        self.described = np.array([row for rows in described.values() for row in rows])
        self.kept = {name: self._keep(name, members) for name, members in found.items()}
        self.seconds = float(np.median([example.signal.extent for example in examples]))
        return {"photographs_per_material": len(self.shown) / len(self.materials)}

    def _describe(self, material: str, examples: Sequence[Example]) -> list[NDArray[np.float64]]:
        held = {id(e.photographs): e.photographs for e in examples if len(e.photographs)}
        places = [(pictures, k) for pictures in held.values() for k in range(len(pictures))]
        drawn = child_rng(self.seed, "photographs", material).permutation(len(places))
        rows: dict[bytes, NDArray[np.float64]] = {}
        for place in drawn[: self.config.photographs]:
            pictures, k = places[place]
            row = self._described(pictures[k])
            rows[row.tobytes()] = row
        return list(rows.values())

    def _described(self, image: Any) -> NDArray[np.float64]:
        if not isinstance(image, Image):
            raise ParameterError(f"condition 'image' must be an Image, got {type(image).__name__}")
        if min(image.pixels.shape[:2]) < SMALLEST:
            raise ParameterError(
                f"a photograph must be at least {SMALLEST} x {SMALLEST} pixels, "
                f"got {image.pixels.shape[1]} x {image.pixels.shape[0]}"
            )
        return descriptor(image)

    def _keep(self, material: str, examples: Sequence[Example]) -> list[Signal]:
        budget = max(1, round(self.config.seconds_per_material * self.kind.rate))
        rng = child_rng(self.seed, "keep", material)
        signals = [example.signal for example in examples]
        return [s for _, s in excerpts(signals, budget, segment=self._segment, least=self._least, rng=rng)]

    @property
    def _segment(self) -> int:
        return max(1, round(self.config.segment_s * self.kind.rate))

    @property
    def _least(self) -> int:
        """Samples that a stretch has at least: two crossfades and searches, and one."""
        return 2 * round((self.config.overlap_s + self.config.search_s) * self.kind.rate) + 1

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return how often an unseen photograph is taken for its own material, and the distance of the signals."""
        right: list[float] = []
        distances: list[float] = []
        for number, example in enumerate(examples):
            if example.material in self.materials:
                right.extend(self.material_of(image) == example.material for image in example.photographs)
            over_time = self.kind.domain == "time"
            if len(example.photographs) and over_time and example.signal.seconds >= SHORTEST_JUDGED_S:
                made = self.generate(
                    {"image": example.photographs[0]}, seconds=example.signal.seconds, seed=number
                )
                distances.append(log_spectral_distance([made], [example.signal]))
        figures = {"photograph_accuracy": right, "log_spectral_distance_db": distances}
        return {name: float(np.mean(values)) for name, values in figures.items() if values}

    def state(self) -> dict[str, Any]:
        return {
            "seconds": self.seconds,
            "described": self.described,
            "shown": list(self.shown),
            "recordings": {name: [s.samples for s in kept] for name, kept in self.kept.items()},
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        if state["recordings"] and tuple(state["recordings"]) != self.materials:
            raise ParameterError(
                f"state is of {', '.join(state['recordings'])}; expected {', '.join(self.materials)}"
            )
        self.seconds = float(state["seconds"])
        self.described = np.asarray(state["described"], dtype=np.float64)
        self.shown = [str(name) for name in state["shown"]]
        self.kept = {
            name: [self._signal(samples) for samples in held] for name, held in state["recordings"].items()
        }

    def _signal(self, samples: Any) -> Signal:
        kind = self.kind
        return Signal(np.asarray(samples), kind.rate, kind.unit, kind.axes, kind.domain)

    # -- use ---------------------------------------------------------------------------------------------

    def classify_photograph(self, image: Image) -> tuple[str, None]:
        """Return the material whose photographs are nearest; it has no probability."""
        return self.material_of(image), None

    def material_of(self, image: Image) -> str:
        """Return the material whose photographs are nearest: each feature by its spread over those kept."""
        if not self.shown:
            raise ParameterError("nearest_photo has not been trained")
        spread = self.described.std(axis=0)
        spread[spread < 1e-9] = 1.0
        far = np.linalg.norm((self.described - self._described(image)) / spread, axis=1)
        nearest = [self.shown[k] for k in np.argsort(far, kind="stable")[: self.config.neighbours]]
        return str(Counter(nearest).most_common(1)[0][0])

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        check_condition(condition, needs=("image",))
        material = self.material_of(condition["image"])
        return concatenated(
            self.kept[material],
            seconds=self.seconds if seconds is None else seconds,
            segment=self._segment,
            overlap_s=self.config.overlap_s,
            search_s=self.config.search_s,
            rng=lambda number: child_rng(seed, "nearest_photo", material, number),
        )


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> NearestPhotoLearner:
    """Return a model that holds nothing yet; it always computes on the processor."""
    return NearestPhotoLearner(config, kind, seed=seed)
