"""Fit of modulated noise per material, speed and force; generation by mixed models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.model import ModelConfig
from tactogram.signal import Signal
from tactogram.signal.modulated_noise import ARRAYS, FRAME_S, LEAST_RATE, ModulatedNoise, mix
from tactogram.signal.modulated_noise_fit import LAGS, fit_modulated_noise, log_likelihood
from tactogram.signal.modulated_noise_synthesis import synthesise_modulated_noise
from tactogram.signal.texture_map import NoiseMap
from tactogram.signal.tones import ARRAYS as TONE_ARRAYS, Tones
from tactogram.training.texture_learner import TextureLearner


class Config(ModelConfig):
    """Fit of the models."""

    lags: int = Field(default=LAGS, ge=1, le=50)
    """Order of the vector autoregression, frames of 10 ms."""
    by_condition: bool = True
    """One model per speed and force if all recordings of a material have them."""


TONE = "tone_"
"""Prefix of the arrays of tones in a checkpoint."""


class ModulatedNoiseLearner(TextureLearner[ModulatedNoise]):
    """One `ModulatedNoise` per material, speed and force."""

    name = "texture_var"
    config: Config

    def map_of(self, conditions: NDArray[np.float64], models: tuple[ModulatedNoise, ...]) -> NoiseMap:
        return NoiseMap(models, conditions)

    def fit(self, signals: Sequence[Signal]) -> ModulatedNoise:
        if self.kind.rate < LEAST_RATE:
            raise ParameterError.must(
                "rate", f"be at least {LEAST_RATE:g} Hz", self.kind.rate, remedy="ar_texture takes any rate"
            )
        return fit_modulated_noise(signals, lags=self.config.lags)

    def mix(self, models: Sequence[ModulatedNoise], weights: ArrayLike) -> ModulatedNoise:
        return mix(models, weights)

    def synthesise(self, model: ModulatedNoise, seconds: float, *, seed: int) -> Signal:
        return synthesise_modulated_noise(model, seconds, seed=seed)

    def nll(self, model: ModulatedNoise, signal: Signal) -> float | None:
        """Return the negative log-likelihood of the gains per frame, nats; None if it is too short."""
        if signal.seconds <= FRAME_S * (model.lags + 1):
            return None
        return -log_likelihood(model, signal)

    def arrays_of(self, model: ModulatedNoise) -> dict[str, NDArray[np.float64]]:
        tones = {f"{TONE}{name}": getattr(model.tones, name) for name in TONE_ARRAYS}
        return {name: getattr(model, name) for name in ARRAYS} | tones

    def model_of(self, arrays: Mapping[str, NDArray[np.float64]]) -> ModulatedNoise:
        noise = {name: arrays[name] for name in ARRAYS if name in arrays}  # `local` is new after 0.1.0
        tones = Tones(*(arrays[f"{TONE}{name}"] for name in TONE_ARRAYS))
        return ModulatedNoise(
            **noise,
            rate=self.kind.rate,
            unit=self.kind.unit,
            axes=self.kind.axes,
            tones=tones,
        )


build = ModulatedNoiseLearner
