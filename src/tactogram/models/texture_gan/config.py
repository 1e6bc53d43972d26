"""Configuration; no publication has this model, so every number is ours unless it cites one."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, PositiveInt, model_validator

from tactogram.training.wave_gan_learner import WaveGANConfig


class Config(WaveGANConfig):
    """Networks of WaveGAN's layout, small enough to train in minutes on two cores."""

    channels: tuple[PositiveInt, ...] = Field(default=(64, 32, 16, 16), min_length=1)
    """Channels after the dense layer and before each transposed convolution; backwards, those of the discriminator."""
    noise_bands: int = Field(default=4, ge=1, le=8)
    """Octaves of noise whose gains over time the generator sets, besides a waveform, as in DDSP (Engel et al. 2020)."""
    sinusoids: int = Field(default=20, ge=0)
    """Sinusoids for the waveform and the last hidden layer, their phases from the latent (Bergmann et al. 2017): a
    short training does not find periodic parts by itself."""
    order: int | None = Field(default=None, ge=0, le=200)
    """Of the autoregressive model of each material; None takes AIC's."""
    match_bands: bool = True
    """After the training, fit the strength of bands, and its distribution over time, to that of recordings
    (Heeger & Bergen 1995)."""
    batch_size: int = Field(default=16, gt=1)
    """Signals per update. Ours."""
    steps: int = Field(default=500, gt=0)
    """Each updates the critic once and the generator once."""
    adversarial: float = Field(default=0.03, ge=0, allow_inf_nan=False)
    """Weight of the critic's score in the generator's loss; 0 trains without a critic."""
    statistics: float = Field(default=1.0, ge=0, allow_inf_nan=False)
    """Weight, in the generator's loss, of the energy distance between texture statistics."""
    learning_rate: float = Field(default=1e-3, gt=0, allow_inf_nan=False)
    """Of the critic; falls to 0 over the training as a cosine (Loshchilov & Hutter 2017), as the generator's does."""
    generator_learning_rate: float = Field(default=2e-3, gt=0, allow_inf_nan=False)
    moving_average: float = Field(default=0.98, ge=0, lt=1)
    """Decay of the average of the generator's weights, which generates; 0 generates with the last weights."""
    conditions: tuple[Literal["speed_mm_s", "force_n"], ...] = ("speed_mm_s", "force_n")
    """Numbers in the label, after the classes: standardised by median and deviation, or 0 throughout unless every
    training recording has them."""

    @property
    def latents(self) -> int:
        """Random numbers per signal, including those of the sinusoids."""
        return self.latent + 2 * self.sinusoids

    @model_validator(mode="after")
    def _trains_the_generator(self) -> Self:
        if not (self.adversarial or self.statistics):
            raise ValueError(
                "adversarial and statistics must not both be 0: nothing would train the generator"
            )
        return self
