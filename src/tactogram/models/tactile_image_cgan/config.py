"""Configuration of the published network (Sec. II-C, Tables 2 to 4), and our assumptions."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, PositiveInt, model_validator

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
    biases: bool = True
    """Whether convolutions have biases. Assumed: the default of PyTorch. Before batch normalisation they have no
    effect."""
    gain: float = Field(default=0.02, gt=0, allow_inf_nan=False)
    """Standard deviation of the initial weights; those of batch normalisation are about 1. Assumed: as in DCGAN
    (Radford et al. 2016, Sec. 4), which has the same layers."""
    image_weight: float = Field(default=5000.0, gt=0, allow_inf_nan=False)
    """Factor of real and generated images, relative to the scores, in the discriminator's input. Sec. II-C: 1, 1,000,
    5,000 and 10,000; 5,000 gave the least error (Fig. 5)."""
    label_input: Literal["planes", "normalised", "projection", "none"] = "planes"
    """How the discriminator sees scores. ``planes``: as further planes of the image (Sec. II-C, Fig. 3). The others are
    ours, since Sec. III-A calls the balance of image and label crucial. ``normalised``: in a branch of its own, whose
    channels are normalised as those of the image's first layer are, so that no weight decides. ``projection``: by an
    inner product with the image's features (Miyato & Koyama 2018). ``none``: only by ``regression_weight``."""
    regression_weight: float = Field(default=0.0, ge=0, allow_inf_nan=False)
    """Weight of the cross-entropy of the scores that a second output predicts from the image alone, as the classes in
    Odena et al. 2017: the discriminator learns it on real images, the generator minimises it. Ours."""
    fake_scores: Literal["uniform", "rated"] = "uniform"
    """Scores of generated images in training: uniform random numbers (Sec. II-C), or those of the real images of the
    batch. Ours: random scores alone reveal a generated image."""
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

    @model_validator(mode="after")
    def _regression_sees_no_scores(self) -> Config:
        if self.regression_weight and self.label_input not in ("projection", "none"):
            raise ValueError(
                "regression_weight must be 0 unless label_input is 'projection' or 'none', where the predicted scores "
                f"are not among the inputs; got {self.regression_weight:g} with {self.label_input!r}"
            )
        if self.label_input == "none" and not self.regression_weight:
            raise ValueError("regression_weight must be > 0 with label_input 'none', got 0")
        return self

    @property
    def size(self) -> int:
        """Rows and columns of an image: 64 as published, 4 doubled by each hidden layer."""
        return int(4 * 2 ** len(self.widths))
