"""Configuration of the published network (Saga et al., Sec. III)."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Count = Annotated[int, Field(gt=0)]

TEXTURE_GAN = (
    "conditions",
    "residual",
    "order",
    "noise_bands",
    "sinusoids",
    "match_bands",
    "statistics",
    "adversarial",
    "generator_learning_rate",
    "schedule",
    "moving_average",
)
"""Keys of the model ``texture_gan``, which were keys of this one before the two were separate."""


class Config(BaseModel):
    """Each number with its place in the paper; "assumed" where the paper gives none."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    # -- networks ----------------------------------------------------------------------------------------

    latent: int = Field(default=100, gt=0)
    """Uniform numbers in -1 to 1 that a signal is made from. Table III, "Uniform(-1,1)", "100+C"."""
    points: int = Field(default=16, gt=0)
    """Samples per axis after the generator's dense layer. Table III, "(n, 3, 16, 1024)"."""
    channels: tuple[Count, ...] = Field(default=(1024, 512, 256, 128, 64), min_length=1)
    """Channels after the dense layer and before each transposed convolution; backwards, those of the
    discriminator. Table III."""
    kernel: int = Field(default=25, gt=1)
    """Table III, "(1, 25, …)": along time only."""
    stride: int = Field(default=4, gt=1)
    """Table III, "Stride = (1, 4)"."""
    leak: float = Field(default=0.2, ge=0, lt=1)
    """Slope of LeakyReLU below 0. Table III."""
    phase_shuffle: int = Field(default=2, ge=0)
    """Table IV."""

    # -- training ----------------------------------------------------------------------------------------

    batch_size: int = Field(default=64, gt=1)
    """Table IV."""
    penalty: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the gradient penalty. Table IV, "WGAN-GP λ"."""
    generator_updates: int = Field(default=2, gt=0)
    """Per step. Table IV, "Generator updates per discriminator: 2", read literally."""
    critic_updates: int = Field(default=1, gt=0)
    """Per step. WaveGAN and WGAN-GP update the critic more often than the generator, which is how Table IV
    may be meant: the recipe ``variant-critic2``."""
    learning_rate: float = Field(default=1e-4, gt=0, allow_inf_nan=False)
    """Table IV, α of Adam."""
    betas: tuple[Annotated[float, Field(ge=0, lt=1)], Annotated[float, Field(ge=0, lt=1)]] = (0.5, 0.9)
    """Table IV, β1 and β2 of Adam."""
    epochs: int = Field(default=40, gt=0)
    """Sec. III-B. An epoch crops each recording once, and a longer one once per whole length that it holds:
    assumed, since the paper does not define it."""
    steps: int | None = Field(default=None, gt=0)
    """Steps in place of ``epochs``. Ours."""

    # -- data --------------------------------------------------------------------------------------------

    repetition: Literal["repeat", "crossfade"] = "repeat"
    """How a recording shorter than the network's length is made longer. ``repeat``: end to end, ten times
    (Sec. III-B), which jumps at each seam. ``crossfade``: joined to itself by crossfades, the recipe
    ``variant-crossfade``. Ours."""
    repetitions: int = Field(default=10, gt=0)
    """Of ``repeat``. Sec. III-B, "repeating each collected data 10 times"; more where ten are too short."""
    within_range: float = Field(default=1.0, gt=0, le=1)
    """Share of the training samples of an axis within the range of tanh: 1 scales by the largest, so that
    nothing is clipped. Assumed: the paper does not say how it scaled."""
    overlap: float = Field(default=0.125, gt=0, le=0.5)
    """Share of the network's length by which the pieces of a longer signal, or of a recording joined to
    itself, are crossfaded. Ours."""

    @property
    def length(self) -> int:
        """Samples per axis of the networks' signals: 16,384 as published."""
        return self.points * math.prod([self.stride] * len(self.channels))

    @model_validator(mode="before")
    @classmethod
    def _not_texture_gan(cls, values: Any) -> Any:
        if moved := [name for name in TEXTURE_GAN if name in values]:
            raise ValueError(
                f"{moved[0]} belongs to the model texture_gan, which was part of stroke_gan; train texture_gan"
            )
        return values

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.kernel < self.stride:
            raise ValueError(f"kernel {self.kernel} must not be shorter than stride {self.stride}")
        if self.phase_shuffle >= self.points * self.stride:
            raise ValueError(f"phase_shuffle {self.phase_shuffle} is as long as what it moves; lower it")
        return self
