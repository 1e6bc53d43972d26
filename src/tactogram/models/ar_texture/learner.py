"""Fit of autoregressive models in one closed-form step; generation by mixed filters driven with noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.model import SignalKind, Stage
from tactogram.models.ar_texture.config import Config
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel, mix
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.synthesis import synthesise
from tactogram.signal.texture_map import TextureMap
from tactogram.training.texture_learner import TextureLearner

if TYPE_CHECKING:
    import torch


class AutoregressiveLearner(TextureLearner[AutoregressiveModel]):
    """One `AutoregressiveModel` per material, speed and force."""

    name = "ar_texture"

    def __init__(self, config: Config, kind: SignalKind) -> None:
        super().__init__(kind)
        self.config, self.by_condition = config, config.by_condition

    def map_of(self, conditions: NDArray[np.float64], models: tuple[AutoregressiveModel, ...]) -> TextureMap:
        return TextureMap(models, conditions, level=self.config.level)

    def step(self, stage: Stage, batch: Any) -> dict[str, float]:
        figures = super().step(stage, batch)
        orders = [model.order for each in self.maps for model in each.models]
        return {"order": float(np.mean(orders)), **figures}

    def fit(self, signals: Sequence[Signal]) -> AutoregressiveModel:
        return fit_autoregressive(
            signals,
            order=self.config.order,
            max_order=min(self.config.max_order, max(map(len, signals)) // 3),
            method=self.config.method,
        )

    def mix(self, models: Sequence[AutoregressiveModel], weights: ArrayLike) -> AutoregressiveModel:
        return mix(models, weights, level=self.config.level)

    def synthesise(self, model: AutoregressiveModel, seconds: float, *, seed: int) -> Signal:
        return synthesise(model, seconds, seed=seed)

    def nll(self, model: AutoregressiveModel, signal: Signal) -> float | None:
        """Return the negative log-likelihood per sample and axis, nats; None if it is too short."""
        if len(signal) <= model.order:
            return None
        error = model.prediction_error(signal)
        variance = np.maximum(model.variance, np.finfo(np.float32).tiny)[:, None]
        return float(0.5 * np.mean(np.log(2 * np.pi * variance) + error**2 / variance))

    def arrays_of(self, model: AutoregressiveModel) -> dict[str, NDArray[np.float64]]:
        return {
            "reflection": model.reflection,
            "innovation": model.innovation,
            "mean": np.asarray(model.mean),
        }

    def model_of(self, arrays: Mapping[str, NDArray[np.float64]]) -> AutoregressiveModel:
        return AutoregressiveModel(**arrays, rate=self.kind.rate, unit=self.kind.unit, axes=self.kind.axes)


def build(
    config: Config, kind: SignalKind, *, seed: int, device: str | torch.device = "cpu"
) -> AutoregressiveLearner:
    """Return an untrained model; it has no random weights and always computes on the processor."""
    return AutoregressiveLearner(config, kind)
