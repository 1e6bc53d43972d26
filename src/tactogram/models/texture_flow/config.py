"""Configuration; no publication has this model, so every number is ours unless it cites one."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from tactogram.model import ModelConfig

Width = Annotated[int, Field(gt=0, multiple_of=8)]


class Config(ModelConfig):
    """Spectrogram, network, training and solver."""

    window_s: float = Field(default=0.05, ge=0.005, le=0.5)
    """Length of the spectrogram's window, s, taken as the nearest power of 2 in samples; a hop is a quarter of it."""
    window_samples: int = Field(default=256, ge=8, le=65536)
    """The same of signals over displacement, samples, as sensors differ too widely in samples per mm for a length."""
    softness: float = Field(default=0.05, gt=0, le=1)
    """Added to a magnitude, as a share of its rms, before the logarithm: nothing is felt of the difference between
    very small magnitudes."""
    widths: tuple[Width, ...] = Field(default=(32, 64, 96), min_length=1)
    """Channels of the network's levels, finest first; each further level halves bins and frames."""
    embedding: int = Field(default=128, ge=4, multiple_of=2)
    """Numbers that represent flow time and condition."""
    frames: int = Field(default=128, ge=8, multiple_of=8)
    """Frames of a training crop."""
    size: int = Field(default=64, ge=8, le=512)
    """Rows and columns of an image."""
    batch_size: int = Field(default=16, gt=0)
    steps: int = Field(default=2500, gt=0)
    start: str = ""
    """Run whose network the training begins with, of as many axes and bins and the same widths; ``texture_flow`` is the
    one that the model comes with. By default the weights are random."""
    learning_rate: float = Field(default=2e-3, gt=0, allow_inf_nan=False)
    """Of AdamW (Loshchilov & Hutter 2019); rises over ``warm_up`` steps, then falls to 0 as a cosine."""
    warm_up: int = Field(default=50, ge=1)
    moving_average: float = Field(default=0.998, gt=0, lt=1)
    """Decay of the average of the weights, which generates."""
    dropped: float = Field(default=0.1, ge=0, lt=1)
    """Share of crops without their material, and, drawn apart, without speed and force; of images without their words
    (Ho & Salimans 2021)."""
    incomplete: float = Field(default=0.5, ge=0, le=1)
    """Share of images without some of their words, as in use any may be missing."""
    references: float = Field(default=0.25, ge=0, le=1)
    """Share of crops whose surface is measured from one other recording of it, not from all."""
    modulated: float = Field(default=0.0, ge=0, le=1)
    """Share of the materials whose recordings are modulated at random in training, so that the network follows swells,
    rattles and pauses that its data lack (Tobin et al. 2017)."""
    photographs: bool = True
    """Whether to learn what photographs tell of a surface."""
    prediction: bool = False
    """Whether to learn what a surface is at other speeds and forces, from one stroke or from words."""
    components: int = Field(default=64, gt=0)
    """Principal components of surfaces that are predicted."""
    straightening_steps: int = Field(default=0, ge=0)
    """Training steps after the others, in which the network learns to reach in one step of the solver what its average
    reaches in ``solver_steps``; 0 is none. It then generates in one step, with the ``guidance`` of its training."""
    guidance: float = Field(default=1.0, ge=0, allow_inf_nan=False)
    """Strength of the condition when generating: 1 as learned, above 1 exaggerated, 0 none (Ho & Salimans 2021)."""
    solver_steps: int = Field(default=6, ge=1)
    """Steps of the solver, each one evaluation of the network, or two with a ``guidance`` other than 1."""
    iterations: int = Field(default=64, ge=0)
    """Of phase recovery."""
    conditions: tuple[Literal["speed_mm_s", "force_n"], ...] = ("speed_mm_s", "force_n")
    """Numbers in the label, standardised by median and deviation, or 0 throughout unless every training recording has
    them."""

    @property
    def multiple(self) -> int:
        """Bins and frames, or rows and columns, of the network are multiples of it."""
        return int(2 ** len(self.widths))

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.modulated and not self.prediction:
            raise ValueError("modulated needs prediction: a material is otherwise one surface, not several")
        if self.frames % self.multiple:
            raise ValueError(
                f"frames must be a multiple of {self.multiple} for these widths, got {self.frames}"
            )
        return self
