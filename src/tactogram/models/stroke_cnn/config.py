"""Configuration of the published network (Saga et al., Sec. II-B), and our assumptions."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, PositiveInt, model_validator

from tactogram.model import ModelConfig

MOST_PASSES = 100
"""Passes over the recordings from which a shorter training is worth trying."""
SETTLED = 0.99
"""Share of the validation windows that a shorter training has to classify correctly to be kept."""


class Config(ModelConfig):
    """Numbers with their place in the paper; "assumed" where the paper states none."""

    window: int = Field(default=200, ge=8)
    """Samples per axis of one input. Sec. II-B: "200-point continuous time series"."""
    filters: tuple[PositiveInt, ...] = Field((64, 64, 128, 128, 256, 256), min_length=1)
    """Filters per convolution, in pairs with a pooling after each pair. Sec. II-B."""
    kernel: int = Field(default=5, ge=1)
    """Filters are 1 x 5: along time only, the same for each axis. Sec. II-B."""
    pool: int = Field(default=2, ge=2)
    """Max-pooling 1 x 2. Sec. II-B."""
    dense: tuple[PositiveInt, PositiveInt] = (256, 256)
    """Widths of the two fully connected layers. Assumed."""
    dropout: float = Field(default=0.5, ge=0, lt=1)
    """Between the second fully connected layer and the output (Sec. II-B); the rate is assumed."""
    learning_rate: float = Field(default=1e-3, gt=0, allow_inf_nan=False)
    """Of Adam (Sec. II-B); the value, Adam's own default, is assumed."""
    schedule: Literal["constant", "one-cycle"] = "constant"
    """Assumed: the paper names none. ``one-cycle`` rises to ``learning_rate`` and falls to 0 (Smith 2018)."""
    batch_size: int = Field(default=64, ge=2)
    """Assumed. Batch normalisation needs two."""
    steps: int = Field(default=5000, gt=0)
    """Assumed: the paper states no number of updates."""
    short_steps: int = Field(default=0, ge=0)
    """Updates of a shorter training that comes first where ``steps`` pass more than 100 times over the recordings; 0
    for none. It is the whole training if it classifies 99 % of the windows of the validation recordings correctly.
    Ours."""
    hop: float = Field(default=0.5, gt=0, le=1)
    """Step between the windows that classify a recording, as a share of the window. Ours: the paper classifies windows;
    we average their log probabilities over a recording."""

    @property
    def hop_samples(self) -> int:
        """Samples from one window of a recording to the next."""
        return max(1, round(self.window * self.hop))

    def input_samples(self, rate: float) -> int:
        """Return the samples of a window, at any rate."""
        return self.window

    def passes(self, samples: int) -> float:
        """Return how often ``steps`` pass over training recordings of ``samples`` per axis in all."""
        return self.steps * self.batch_size * self.window / samples

    @model_validator(mode="after")
    def _window_is_long_enough(self) -> Self:
        if self.points() < 1:
            raise ValueError(f"window {self.window} is too short for these filters, kernel and pool")
        return self

    def points(self) -> int:
        """Return the samples per axis before the dense layers."""
        points = self.window
        for number in range(len(self.filters)):
            points += 2 * (self.kernel // 2) - self.kernel + 1
            if number % 2:
                points //= self.pool
        return points
