"""Fit of autoregressive models in one closed-form step; generation by mixed filters driven with noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.model import (
    Condition,
    Example,
    SignalKind,
    Stage,
    check_condition,
    check_state,
    material_weights,
)
from tactogram.models.ar_texture.config import Config
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel, mix
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.synthesis import synthesise
from tactogram.signal.texture_map import NAMES, TextureMap
from tactogram.training.one_step_learner import OneStepLearner

if TYPE_CHECKING:
    import torch


class TextureLearner(OneStepLearner):
    """One `TextureMap` per material."""

    def __init__(self, config: Config, kind: SignalKind) -> None:
        kind.require_materials("ar_texture")
        self.config, self.kind, self.materials = config, kind, kind.materials
        self.maps: list[TextureMap] = []
        self.seconds = 0.0

    # -- training ----------------------------------------------------------------------------------------

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        examples: Sequence[Example] = batch
        self.maps = [self._fit(members) for members in self.kind.by_material(examples).values()]
        self.seconds = float(np.median([example.signal.seconds for example in examples]))
        orders = [model.order for surface in self.maps for model in surface.models]
        return {"order": float(np.mean(orders)), **self.validate(examples)}

    def _fit(self, examples: Sequence[Example]) -> TextureMap:
        """Return the models of one material at each speed and force, as far as all its recordings have them."""
        values = np.array([[_number(example.condition.get(name)) for name in NAMES] for example in examples])
        known = ~np.isnan(values).any(axis=0) & self.config.by_condition
        conditions, group = np.unique(np.where(known, values, 0.0), axis=0, return_inverse=True)
        models = []
        for number in range(len(conditions)):
            signals = [e.signal for e, g in zip(examples, group.ravel(), strict=True) if g == number]
            longest = max(map(len, signals))
            models.append(
                fit_autoregressive(
                    signals,
                    order=self.config.order,
                    max_order=min(self.config.max_order, longest // 3),
                    method=self.config.method,
                )
            )
        conditions[:, ~known] = np.nan
        return TextureMap(models, conditions, level=self.config.level)

    def validate(self, examples: Sequence[Example]) -> dict[str, float]:
        """Return ``nll``: negative log-likelihood of recordings per sample and axis, nats."""
        scores = []
        for example in examples:
            if example.material not in self.materials:
                continue
            model = self._model({"material": example.material, **_conditions(example)}, lenient=True)
            if len(example.signal) > model.order:
                error = model.prediction_error(example.signal)
                variance = np.maximum(model.variance, np.finfo(np.float32).tiny)[:, None]
                scores.append(0.5 * np.mean(np.log(2 * np.pi * variance) + error**2 / variance))
        return {"nll": float(np.mean(scores))} if scores else {}

    def state(self) -> dict[str, Any]:
        return {
            "seconds": self.seconds,
            "materials": list(self.materials),
            "maps": [
                {
                    "conditions": surface.conditions,
                    "models": [
                        {"reflection": m.reflection, "innovation": m.innovation, "mean": m.mean}
                        for m in surface.models
                    ],
                }
                for surface in self.maps
            ],
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        check_state(state["materials"], self.materials)
        self.seconds = float(state["seconds"])
        self.maps = [
            TextureMap(
                [self._loaded(model) for model in surface["models"]],
                np.asarray(surface["conditions"]),
                level=self.config.level,
            )
            for surface in state["maps"]
        ]

    def _loaded(self, values: Mapping[str, Any]) -> AutoregressiveModel:
        arrays = {name: np.asarray(value, np.float64) for name, value in values.items()}
        return AutoregressiveModel(**arrays, rate=self.kind.rate, unit=self.kind.unit, axes=self.kind.axes)

    # -- use ---------------------------------------------------------------------------------------------

    def generate(self, condition: Condition, *, seconds: float | None = None, seed: int) -> Signal:
        check_condition(condition, needs=("material",), takes=NAMES)
        model = self._model(condition)
        return synthesise(model, self.seconds if seconds is None else seconds, seed=seed)

    def model(self, condition: Condition) -> AutoregressiveModel:
        """Return the process behind `generate`, for streaming and for its spectrum."""
        check_condition(condition, needs=("material",), takes=NAMES)
        return self._model(condition)

    def _model(self, condition: Condition, *, lenient: bool = False) -> AutoregressiveModel:
        """Return the mix over materials, and within each over speed and force, in one step.

        ``lenient`` ignores a speed or force that a material's recordings do not have.
        """
        if not self.maps:
            raise ParameterError("ar_texture has not been trained")
        chosen: list[AutoregressiveModel] = []
        shares: list[NDArray[np.float64]] = []
        for surface, weight in zip(self.maps, material_weights(condition, self.materials), strict=True):
            if weight > 0:
                point = [
                    condition.get(name) if known or not lenient else None
                    for name, known in zip(NAMES, surface.has_conditions, strict=True)
                ]
                chosen += surface.models
                shares.append(weight * surface.weights(*point))
        return mix(chosen, np.concatenate(shares), level=self.config.level)


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> TextureLearner:
    """Return an untrained model; it has no random weights and always computes on the processor."""
    return TextureLearner(config, kind)


def _number(value: Any) -> float:
    return np.nan if value is None else float(value)


def _conditions(example: Example) -> dict[str, Any]:
    return {name: example.condition[name] for name in NAMES if example.condition.get(name) is not None}
