"""Configuration of Neshov et al. 2026, every number with its place; "assumed" where the paper states none.

Tables 1 and 2 agree with their totals, 54,418,049 and 8,296,515. What looks like an error in them:

* Table 1, ReLU before the last transposed convolution: "[1, 256, 256]" must be [128, 128, 128], the 64 channels that
  come up and the 64 that are handed across; only so has the convolution its 128 x 16 + 1 = 2049 parameters. Each other
  ReLU of the decoder is listed with its joined channels, too.
* Table 1, input: "+ 90", as the table reads in plain text, is a label of 9 numbers and, in the next column, 0
  parameters. Conditional batch norm has 10,240 = 2 x (9 x 512 + 512): nine classes.
* Table 2, "[1, 1, 128, 128]" after average pooling stands for photograph and spectrogram, one channel each.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tactogram.evaluation.pictures.checkpoint_choice import DistanceName
from tactogram.nn.label_predictor import PredictorConfig
from tactogram.nn.photo_translation import PairConfig

Beta = Annotated[float, Field(ge=0, lt=1)]
Count = Annotated[int, Field(gt=0)]


class Config(BaseModel):
    """Defaults are the paper's."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    pairs: PairConfig = PairConfig()
    """Photographs, pictures and how they are paired. Sec. 4.1."""
    predictor: PredictorConfig = PredictorConfig()
    """The label predictor. Sec. 3.1 and 3.2."""

    # -- networks ----------------------------------------------------------------------------------------

    widths: tuple[Count, ...] = Field(default=(64, 128, 256, 512, 512, 512, 512, 512), min_length=2)
    """Channels after each stage of the encoder. Table 1."""
    conditional: bool = True
    """Conditional batch norm at the bottleneck. Sec. 3.1; without it nothing stands there, as in pix2pix, and no label
    predictor is trained ("W/o CBN", Table 4)."""
    label_gain: float = Field(default=0.02, ge=0, allow_inf_nan=False)
    """Standard deviation of the first weights of the label in conditional batch norm. Assumed: that of the others. Adam
    moves a weight by about its learning rate in a step, so that a training of some hundred steps never hears a label
    that begins so quietly; short recipes begin at 1."""
    label: Literal["predicted", "true"] = "predicted"
    """What conditions the generator in training. Sec. 3.1, "this predicted label"; the true one is a variant."""
    discriminators: int = Field(default=3, gt=0)
    """N_D. Sec. 3.1; Table 3 tries 1 to 4."""
    layers: int = Field(default=3, gt=0)
    """L, convolutions of stride 2 in each. Sec. 3.1; Table 3 tries 1 to 4."""
    width: int = Field(default=64, gt=0)
    """Channels after the first convolution of a discriminator. Table 2."""
    gain: float = Field(default=0.02, gt=0, allow_inf_nan=False)
    """Standard deviation of the initial weights. Sec. 3.2, "normal distribution with a gain of 0.02"."""

    match_bands: bool = False
    """After the training, fit the strength of bands of signals, and how it is spread, to the recordings of the label
    (Heeger & Bergen 1995, see `tactogram.signal.band_levels`). Pictures stay as they are. Ours."""

    # -- training ----------------------------------------------------------------------------------------

    l1: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the L1 loss. Sec. 3.1, lambda_L1."""
    feature_matching: float = Field(default=40.0, ge=0, allow_inf_nan=False)
    """Weight of the feature matching loss. Sec. 3.1, lambda_FM."""
    batch_size: int = Field(default=32, gt=1)
    """Sec. 3.2."""
    learning_rate: float = Field(default=2e-4, gt=0, allow_inf_nan=False)
    """Of Adam. Sec. 3.2."""
    betas: tuple[Beta, Beta] = (0.5, 0.999)
    """Of Adam. Sec. 3.2."""
    epochs: int = Field(default=200, gt=0)
    """Over all pairs. Sec. 3.2."""
    constant: float = Field(default=0.5, ge=0, le=1)
    """Share of the training before the learning rate falls linearly to 0. Sec. 3.2, the first 100 of 200 epochs."""
    steps: int | None = Field(default=None, gt=0)
    """Steps in place of ``epochs``. Ours."""
    choose_every: int | None = Field(default=None, gt=0)
    """Steps between judgements on the validation part; None: once per epoch. Sec. 3.2, "monitored … during
    training"."""
    choose_by: DistanceName = "lpips"
    """What weights are chosen by. Sec. 3.2, LPIPS; where its weights are not at hand, and for short trainings,
    ``row_statistics``. The run's state says which it was."""
    lpips_weights: str = ""
    """File of AlexNet's weights; empty looks into torch's cache."""

    @model_validator(mode="after")
    def _bands_go_by_label(self) -> Self:
        if self.match_bands and not self.conditional:
            raise ValueError("match_bands goes by the label, which conditional = false leaves out")
        return self
