"""Fit of autoregressive models in one closed-form step; generation by mixed filters driven with noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from tactogram.model import ModelConfig, Stage
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel, mix
from tactogram.signal.autoregressive_fit import fit_autoregressive
from tactogram.signal.synthesis import synthesise
from tactogram.signal.texture_map import TextureMap
from tactogram.training.texture_learner import TextureLearner


class Config(ModelConfig):
    """Fit and mixing of the models: the publications' choices, and ours where they state none."""

    order: int | None = Field(default=None, ge=0, le=200)
    """Order of every model; None takes each model's least AIC. The toolkit has one order per surface."""
    max_order: int = Field(default=60, ge=0, le=200)
    """Highest order AIC may take. Ours: higher ones do not lower the log-spectral distance to unseen recordings."""
    method: Literal["burg", "yule-walker"] = "burg"
    """Burg's recursion over all recordings of a condition (de Waele & Broersen 2000). Ours, since it is less biased
    on short recordings; the publications solve the Yule-Walker equations of one segment."""
    by_condition: bool = True
    """One model per speed and force if all recordings of a material have them (Culbertson et al. 2012)."""
    level: Literal["log", "linear"] = "log"
    """Interpolation of power between models. Ours: in dB, which feels even; the toolkit interpolates the variance of
    the innovations, so that the level between two models is not between their levels."""


class AutoregressiveLearner(TextureLearner[AutoregressiveModel]):
    """One `AutoregressiveModel` per material, speed and force."""

    name = "ar_texture"
    config: Config

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


build = AutoregressiveLearner
