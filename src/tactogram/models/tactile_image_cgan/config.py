"""Configuration of the published network (Sec. II-C, Tables 2 to 4), and our assumptions."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, PositiveInt

from tactogram.model import ModelConfig

Beta = Annotated[float, Field(ge=0, lt=1)]


class Config(ModelConfig):
    """Numbers with their place in the paper; "assumed" where it states none."""

    noise: int = Field(default=100, gt=0)
    """Standard normal numbers, besides the scores. Sec. II-C, Table 2, "100 + 10"; the 10 are the ratings' words."""
    widths: tuple[PositiveInt, ...] = Field(default=(512, 256, 128, 64), min_length=1, max_length=6)
    """Channels after each of the generator's hidden layers, and backwards of the discriminator's. Tables 2 and 3."""
    leak: float = Field(default=0.2, ge=0, lt=1)
    """Slope of LeakyReLU below 0. Sec. II-C, Eq. 1, a = 0.2."""
    gain: float = Field(default=0.02, gt=0, allow_inf_nan=False)
    """Standard deviation of the initial weights; those of batch normalisation are about 1. Assumed: as in DCGAN
    (Radford et al. 2016, Sec. 4), which has the same layers."""
    image_weight: float = Field(default=5000.0, gt=0, allow_inf_nan=False)
    """Factor of real and generated images, relative to the scores, in the discriminator's input. Sec. II-C: 1, 1,000,
    5,000 and 10,000; 5,000 gave the least error (Fig. 5)."""
    words_weight: float = Field(default=0.0, ge=0, allow_inf_nan=False)
    """Weight, in the generator's loss, of the squared difference of the scores asked and those that a regression on the
    real images predicts of the generated image (`ScoreRegression`). Ours: as published there is none."""
    learning_rate: float = Field(default=0.002, gt=0, allow_inf_nan=False)
    """Of Adam, both networks. Table 4, step size."""
    betas: tuple[Beta, Beta] = (0.5, 0.999)
    """Of Adam. Table 4."""
    epsilon: float = Field(default=1e-8, gt=0, allow_inf_nan=False)
    """Of Adam. Table 4."""
    batch_size: int = Field(default=32, gt=1)
    """Table 4."""
    updates: int = Field(default=1000, gt=0)
    """Of each network. Table 4, "Iterations 1,000", read as updates: as passes over 320 images it would be 10,000."""

    @property
    def size(self) -> int:
        """Rows and columns of an image: 64 as published, 4 doubled by each hidden layer."""
        return int(4 * 2 ** len(self.widths))
