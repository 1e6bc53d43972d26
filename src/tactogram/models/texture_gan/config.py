"""Configuration; no publication has this model, so every number is ours unless it cites one."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Count = Annotated[int, Field(gt=0)]


class Config(BaseModel):
    """Networks of WaveGAN's layout, small enough to train in minutes on two cores."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    # -- networks ----------------------------------------------------------------------------------------

    latent: int = Field(default=100, gt=0)
    """Uniform numbers in -1 to 1 that a signal is made from. Saga et al. 2020, Table III."""
    points: int = Field(default=16, gt=0)
    """Samples per axis after the generator's dense layer. Saga et al. 2020, Table III."""
    channels: tuple[Count, ...] = Field(default=(64, 32, 16, 16), min_length=1)
    """Channels after the dense layer and before each transposed convolution; backwards, those of the
    discriminator."""
    kernel: int = Field(default=25, gt=1)
    """Along time. Saga et al. 2020, Table III."""
    stride: int = Field(default=4, gt=1)
    """Saga et al. 2020, Table III."""
    leak: float = Field(default=0.2, ge=0, lt=1)
    """Slope of LeakyReLU below 0. Saga et al. 2020, Table III."""
    phase_shuffle: int = Field(default=2, ge=0)
    """Saga et al. 2020, Table IV."""
    noise_bands: int = Field(default=4, ge=1, le=8)
    """Octaves of noise whose gains over time the generator gives, beside a waveform, as in DDSP (Engel et al.
    2020)."""
    sinusoids: int = Field(default=20, ge=0)
    """Sinusoids that the waveform and the last hidden layer may use, their phases from the latent (Bergmann et
    al. 2017): a short training does not find what repeats by itself."""

    # -- filters -----------------------------------------------------------------------------------------

    order: int | None = Field(default=None, ge=0, le=200)
    """Of the autoregressive model of each material; None takes AIC's."""
    match_bands: bool = True
    """After the training, fit the strength of bands, and its distribution over time, to that of recordings
    (Heeger & Bergen 1995)."""

    # -- training ----------------------------------------------------------------------------------------

    batch_size: int = Field(default=16, gt=1)
    steps: int = Field(default=500, gt=0)
    """Each updates the critic once and the generator once."""
    adversarial: float = Field(default=0.03, ge=0, allow_inf_nan=False)
    """Weight of the critic's score in the generator's loss; 0 trains without a critic."""
    statistics: float = Field(default=1.0, ge=0, allow_inf_nan=False)
    """Weight, in the generator's loss, of the energy distance between texture statistics."""
    penalty: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the gradient penalty. Gulrajani et al. 2017, Algorithm 1."""
    learning_rate: float = Field(default=1e-3, gt=0, allow_inf_nan=False)
    """Of the critic; falls to 0 over the training as a cosine (Loshchilov & Hutter 2017), as the generator's does."""
    generator_learning_rate: float = Field(default=2e-3, gt=0, allow_inf_nan=False)
    betas: tuple[Annotated[float, Field(ge=0, lt=1)], Annotated[float, Field(ge=0, lt=1)]] = (0.5, 0.9)
    """β1 and β2 of Adam. Saga et al. 2020, Table IV."""
    moving_average: float = Field(default=0.98, ge=0, lt=1)
    """Decay of the average of the generator's weights that generates; 0 takes the last weights."""

    # -- data --------------------------------------------------------------------------------------------

    conditions: tuple[Literal["speed_mm_s", "force_n"], ...] = ("speed_mm_s", "force_n")
    """Numbers beside the classes in the label: standardised by median and deviation, or 0 throughout where not
    every training recording names them."""
    overlap: float = Field(default=0.125, gt=0, le=0.5)
    """Share of the network's length by which the pieces of a longer signal, or of a recording joined to
    itself, are crossfaded."""

    @property
    def latents(self) -> int:
        """Random numbers that a signal is made from, including those of the sinusoids."""
        return self.latent + 2 * self.sinusoids

    @property
    def length(self) -> int:
        """Samples per axis of the networks' signals."""
        return self.points * math.prod([self.stride] * len(self.channels))

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.kernel < self.stride:
            raise ValueError(f"kernel {self.kernel} must not be shorter than stride {self.stride}")
        if self.phase_shuffle >= self.points * self.stride:
            raise ValueError(f"phase_shuffle {self.phase_shuffle} is as long as what it moves; lower it")
        if not (self.adversarial or self.statistics):
            raise ValueError(
                "adversarial and statistics must not both be 0: nothing would train the generator"
            )
        return self
