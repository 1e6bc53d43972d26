"""Configuration of the paper, every number with its place; "assumed" where it states none."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, PositiveInt, model_validator

from tactogram.model import ModelConfig

Beta = Annotated[float, Field(ge=0, lt=1)]
Share = Annotated[float, Field(ge=0, le=1)]

GROUPS = {1: "A", 2: "B", 3: "C", 4: "D", 12: "E"}
"""The paper's name of a classification by its number of clusters. Sec. IV-B."""


class Config(ModelConfig):
    """Defaults are the paper's, for group D."""

    clusters: int = Field(default=4, gt=0)
    """Clusters of the surfaces, each with its networks: 1, 2, 3, 4 or 12 in groups A to E. Sec. IV-B."""
    linkage: Literal["ward", "average", "complete", "single"] = "ward"
    """Of the cluster analysis, over Euclidean distances of the mean ratings. Assumed: Sec. IV-B names neither."""
    display_by_cluster: bool = False
    """Divide the display signals, too, each to the cluster with the nearest mean ratings. Ours: the paper has "a
    separate CGAN … for each cluster" (Sec. IV-C) and does not state which display data it sees."""

    # -- spectra, Sec. III-B
    stable_s: float = Field(default=2.0, ge=1, allow_inf_nan=False)
    """Stable part of a measurement. Sec. III-B: 2 s of 2.5 s, not stated which. Assumed: the middle."""
    hop_s: float = Field(default=0.05, gt=0, allow_inf_nan=False)
    """Between one-second windows. Sec. III-B."""
    bins: int = Field(default=1000, gt=0)
    """Of the amplitude spectrum, 1 Hz apart, from 1 Hz on. Sec. III-B."""
    spectrum_weight: float = Field(default=1.0, gt=0, allow_inf_nan=False)
    """Root mean square of all bins of each side's spectra in the networks' input, relative to labels of 0 to 1.
    Assumed: the paper does not state its scaling. Hatori et al. 2025, Sec. II-C, weight images like this."""

    # -- networks, Tables 2 and 3
    generator_widths: tuple[PositiveInt, ...] = Field(default=(1024, 512, 256, 128), min_length=1)
    """Table 2."""
    dropout_after: tuple[PositiveInt, ...] = (2, 4)
    """Hidden layers, from 1, with dropout after their batch normalisation. Table 2."""
    dropout: float = Field(default=0.5, ge=0, lt=1)
    """Sec. IV-A."""
    discriminator_widths: tuple[PositiveInt, ...] = Field(default=(64, 32), min_length=1)
    """Table 3."""
    leak: float = Field(default=0.01, ge=0, lt=1)
    """Negative slope of LeakyReLU. Eq. (1)."""

    # -- training, Table 4
    learning_rate: float = Field(default=1e-3, gt=0, allow_inf_nan=False)
    """Of Adam, alpha. Table 4."""
    discriminator_learning_rate: float | None = Field(default=None, gt=0, allow_inf_nan=False)
    """Of the discriminator's Adam if different: a slower one gives the generator time. Ours."""
    betas: tuple[Beta, Beta] = (0.9, 0.999)
    """Of Adam. Table 4."""
    epsilon: float = Field(default=1e-8, gt=0, allow_inf_nan=False)
    """Of Adam. Table 4."""
    batch_size: int = Field(default=64, gt=1)
    """Table 4. Of each side: 64 generated and 64 display spectra. Assumed."""
    words_weight: float = Field(default=0.0, ge=0, allow_inf_nan=False)
    """Weight, in the generator's loss, of the squared difference of the scores asked and those that a regression on the
    display signals predicts of the generated spectrum (`ScoreRegression`). Ours: as published there is none."""
    iterations: int = Field(default=200_000, gt=0)
    """Per cluster. Table 4."""

    rate_low: Share = 0.4
    """Lowest correct rate of the discriminator at which the generator is chosen. Sec. IV-C, "between 40% and 60%"."""
    rate_high: Share = 0.6
    """Highest. Sec. IV-C, likewise."""
    smooth: int = Field(default=100, gt=0)
    """Iterations up to the current one that the correct rate is averaged over. Ours: one batch has 128 answers, whose
    share has a standard deviation of 4.4 points by chance."""
    choose_after: int = Field(default=0, ge=0)
    """Initial iterations of which none is chosen. Ours: an untrained discriminator is also correct in half the cases, a
    success by the printed rule."""

    phase: Literal["low_crest", "random"] = "low_crest"
    """Phases of the waveform: of a low crest factor, or random. Not stated in the paper."""
    stored: int = Field(default=84, gt=0)
    """Sensor spectra of each surface stored with the weights, for use without a recording."""
    iterations_per_step: int = Field(default=50, gt=0)
    """Iterations per step of the training loop, which logs and saves between steps. Batches and dropout are drawn by
    step: another number is another draw of the same training."""

    @model_validator(mode="after")
    def _ranges_are_valid(self) -> Config:
        if self.rate_low >= self.rate_high:
            raise ValueError(f"rate_low must be < rate_high, got {self.rate_low:g} and {self.rate_high:g}")
        if any(layer > len(self.generator_widths) for layer in self.dropout_after):
            raise ValueError(
                f"dropout_after must name hidden layers 1 to {len(self.generator_widths)}, got {self.dropout_after}"
            )
        return self

    @property
    def group(self) -> str:
        """The paper's name of this classification, e.g. ``"group D"``."""
        letter = GROUPS.get(self.clusters)
        return f"group {letter}" if letter else f"{self.clusters} clusters"
