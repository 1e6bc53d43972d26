"""Learner of textures in closed form: one model per material, speed and force, mixed between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.model import (
    Condition,
    Example,
    Limit,
    Model,
    Stage,
    check_condition,
    limits_within,
    material_weights,
)
from tactogram.signal import Signal
from tactogram.signal.texture_map import NAMES, ModelMap, group_by_condition

M = TypeVar("M")
"""Model of one texture."""


class TextureLearner(Model, Generic[M]):
    """Fitting, mixing and generation; a model of textures defines the methods that raise `NotImplementedError`.

    With ``config.by_condition`` there is one model per speed and force if all recordings of a material have them.
    """

    name: str
    saved = ("seconds", "materials")

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self.kind.require_materials(self.name)
        self.maps: list[ModelMap[M]] = []
        """Models of each material over the recorded speeds and forces."""
        self.seconds = 0.0

    def fit(self, signals: Sequence[Signal]) -> M:
        """Return the model of recordings of one material, speed and force."""
        raise NotImplementedError

    def mix(self, models: Sequence[M], weights: ArrayLike) -> M:
        """Return the model between others."""
        raise NotImplementedError

    def synthesise(self, model: M, seconds: float, *, seed: int) -> Signal:
        """Return a signal."""
        raise NotImplementedError

    def nll(self, model: M, signal: Signal) -> float | None:
        """Return the negative log-likelihood of a recording, None if it is too short."""
        raise NotImplementedError

    def arrays_of(self, model: M) -> dict[str, NDArray[np.float64]]:
        """Return what a checkpoint stores of a model."""
        raise NotImplementedError

    def model_of(self, arrays: Mapping[str, NDArray[np.float64]]) -> M:
        """Return the model that `arrays_of` describes."""
        raise NotImplementedError

    def map_of(self, conditions: NDArray[np.float64], models: tuple[M, ...]) -> ModelMap[M]:
        """Return the map over the speeds and forces of one material's models."""
        raise NotImplementedError

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        """Fit every model, and return the figures of `validate` on the training data."""
        examples: Sequence[Example] = batch
        maps = []
        for members in self.kind.by_material(examples).values():
            points, groups = group_by_condition(
                [e.condition for e in members], known=self.config.by_condition
            )
            models = tuple(self.fit([members[k].signal for k in group]) for group in groups)
            maps.append(self.map_of(points, models))
        self.maps = maps
        self.seconds = float(np.median([example.signal.seconds for example in examples]))
        return self.validate(examples)

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return ``negative_log_likelihood``, the mean of `nll`."""
        scores = []
        for example in examples:
            if example.material in self.materials:
                known = {n: value for n in NAMES if (value := example.condition.get(n)) is not None}
                model = self._model({"material": example.material, **known}, lenient=True)
                scores.append(self.nll(model, example.signal))
        measured = [score for score in scores if score is not None]
        return {"negative_log_likelihood": float(np.mean(measured))} if measured else {}

    def state(self) -> dict[str, Any]:
        """Return the models with their conditions, by material."""
        maps = [
            {"conditions": each.conditions, "models": [self.arrays_of(model) for model in each.models]}
            for each in self.maps
        ]
        return super().state() | {"maps": maps}

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Restore the models of `state`."""
        super().load_state(state)
        self.maps = [
            self.map_of(
                np.asarray(each["conditions"]),
                tuple(
                    self.model_of({name: np.asarray(value, np.float64) for name, value in arrays.items()})
                    for arrays in each["models"]
                ),
            )
            for each in state["maps"]
        ]

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        """Return a signal of ``condition``, by default as long as the median of the training recordings."""
        model = self.model(condition)
        return self.synthesise(model, self.seconds if seconds is None else seconds, seed=seed)

    def limits(self, condition: Condition) -> list[Limit]:
        """Return the speed and force of ``condition`` that count as others for a material, the nearest recorded."""
        weights = material_weights(condition, self.materials)
        limits: list[Limit] = []
        for index in np.flatnonzero(weights).tolist():
            points = self.maps[index]
            used = points.weights(*map(condition.get, NAMES)) @ points.conditions
            ranges = {name: (value, value) for name, value in zip(NAMES, used, strict=True)}
            limits += limits_within(condition, ranges, f"of {self.materials[index]}")
        return limits

    def model(self, condition: Condition) -> M:
        """Return the process behind `generate`."""
        check_condition(condition, needs=("material",), takes=NAMES)
        return self._model(condition)

    def _model(self, condition: Condition, *, lenient: bool = False) -> M:
        """Return the mix over materials, and within each over speed and force, in one step.

        ``lenient`` ignores a speed or force that a material's recordings do not have.
        """
        if not self.maps:
            raise ParameterError(f"{self.name} has not been trained")
        chosen: list[M] = []
        shares: list[NDArray[np.float64]] = []
        weights = material_weights(condition, self.materials)
        for points, weight in zip(self.maps, weights, strict=True):
            if weight > 0:
                point = [
                    condition.get(name) if known or not lenient else None
                    for name, known in zip(NAMES, points.has_conditions, strict=True)
                ]
                within = points.weights(*point)
                places = np.flatnonzero(within)
                chosen += points.moved(places, point[0])
                shares.append(weight * within[places])
        return self.mix(chosen, np.concatenate(shares))
