"""Every number of the published network (Saga et al., Sec. III), and what is ours beside it."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Count = Annotated[int, Field(gt=0)]


class Config(BaseModel):
    """Numbers with their place in the paper; "assumed" where it states none; "ours" is off by default."""

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
    """Sec. III-B. In an epoch each recording is cropped once, and a longer one once per whole length that it
    holds: ours, since the paper does not say what it counted."""
    steps: int | None = Field(default=None, gt=0)
    """Steps in place of ``epochs``. Ours."""

    # -- data --------------------------------------------------------------------------------------------

    repetition: Literal["repeat", "crossfade"] = "repeat"
    """How a recording shorter than the network's length is made longer. ``repeat``: end to end, ten times
    (Sec. III-B), which jumps at each seam. ``crossfade``: joined to itself by crossfades. Ours."""
    repetitions: int = Field(default=10, gt=0)
    """Of ``repeat``. Sec. III-B, "repeating each collected data 10 times"; more where ten do not reach."""
    within_range: float = Field(default=1.0, gt=0, le=1)
    """Share of the training samples of an axis that the range of tanh holds: 1 scales by the largest, so that
    nothing is clipped. Assumed: the paper does not say how it scaled. Without effect on whitened signals."""
    conditions: tuple[Literal["speed_mm_s", "force_n"], ...] = ()
    """Numbers that stand beside the classes in the label: standardised by median and deviation, or 0 throughout
    where not every training recording names them. Sec. V: "by inputting the numerical value of the speed or the
    pressure", named there as future work."""
    overlap: float = Field(default=0.125, gt=0, le=0.5)
    """Share of the network's length by which the pieces of a longer signal, or of a recording joined to
    itself, are crossfaded. Ours."""

    # -- ours, for short trainings: all off by default ------------------------------------------------------

    residual: Literal["none", "autoregressive"] = "none"
    """``autoregressive``: an autoregressive model per material is fitted first; the networks see what it does
    not foresee (Atal & Remde 1982), and its filter colours what they make. Ours."""
    order: int | None = Field(default=None, ge=0, le=200)
    """Of that model; None takes AIC's. Ours."""
    noise_bands: int = Field(default=0, ge=0, le=8)
    """Bands of noise whose gains over time the generator gives, beside a waveform, as in DDSP (Engel et al.
    2020); 0 gives the waveform of the paper, within -1 to 1. Ours."""
    sinusoids: int = Field(default=0, ge=0)
    """Sinusoids that the last hidden layer may use, their phases from the latent (Bergmann et al. 2017): a
    short training does not find what repeats by itself. Ours."""
    match_bands: bool = False
    """After the training, fit the strength of bands, and how it is spread, to that of recordings (Heeger & Bergen
    1995). Ours."""
    statistics: float = Field(default=0.0, ge=0, allow_inf_nan=False)
    """Weight, in the generator's loss, of the energy distance between texture statistics. Ours."""
    adversarial: float = Field(default=1.0, ge=0, allow_inf_nan=False)
    """Weight of the critic's verdict in the generator's loss. Table IV, "WGAN-GP", has none, which is 1."""
    generator_learning_rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """None: that of the critic, as in Table IV, which has one. Ours."""
    schedule: Literal["constant", "cosine"] = "constant"
    """Of both learning rates; ``cosine`` falls to 0 over the training (Loshchilov & Hutter 2017). Ours."""
    moving_average: float = Field(default=0.0, ge=0, lt=1)
    """Decay of the average of the generator's weights that generates; 0 takes the last weights. Ours."""

    @property
    def latents(self) -> int:
        """Random numbers that a signal is made from, those of the sinusoids included."""
        return self.latent + 2 * self.sinusoids

    @property
    def length(self) -> int:
        """Samples per axis that the networks make and judge: 16,384 as published."""
        return self.points * math.prod([self.stride] * len(self.channels))

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.kernel < self.stride:
            raise ValueError(f"kernel {self.kernel} must not be shorter than stride {self.stride}")
        if self.phase_shuffle >= self.points * self.stride:
            raise ValueError(f"phase_shuffle {self.phase_shuffle} is as long as what it moves; lower it")
        if self.noise_bands and self.residual == "none":
            raise ValueError(
                'noise_bands needs residual = "autoregressive": tanh\'s range has no noise in it'
            )
        if self.sinusoids and not self.noise_bands:
            raise ValueError("sinusoids stand beside noise in bands; set noise_bands too")
        return self
