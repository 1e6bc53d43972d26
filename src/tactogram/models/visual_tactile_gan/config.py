"""Configuration of Neshov et al. 2026, every number with its place; "assumed" where the paper states none.

Tables 1 and 2 agree with their totals, 54,418,049 and 8,296,515. Apparent errors in them:

* Table 1, ReLU before the last transposed convolution: "[1, 256, 256]" must be [128, 128, 128], the 64 channels from
  below and the 64 of the skip connection; only then has the convolution its 128 x 16 + 1 = 2049 parameters. Every other
  ReLU of the decoder is listed with its joined channels, too.
* Table 1, input: "+ 90", as the table reads in plain text, is a label of 9 numbers and, in the next column, 0
  parameters. Conditional batch norm has 10,240 = 2 x (9 x 512 + 512): nine classes.
* Table 2, "[1, 1, 128, 128]" after average pooling means photograph and spectrogram, one channel each.
"""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, PositiveInt, model_validator

from tactogram.nn.label_predictor import PredictorConfig
from tactogram.training.picture_learner import PictureConfig


class Config(PictureConfig):
    """Defaults are the paper's, as those of `PictureConfig` are."""

    predictor: PredictorConfig = PredictorConfig()
    """The label predictor. Sec. 3.1 and 3.2."""

    widths: tuple[PositiveInt, ...] = Field(default=(64, 128, 256, 512, 512, 512, 512, 512), min_length=2)
    """Channels after each stage of the encoder. Table 1."""
    conditional: bool = True
    """Conditional batch norm at the bottleneck. Sec. 3.1; without it, as in pix2pix, no label predictor is trained
    ("W/o CBN", Table 4)."""
    label_gain: float = Field(default=0.02, ge=0, allow_inf_nan=False)
    """Standard deviation of the label's initial weights in conditional batch norm. Assumed: that of the others. Adam
    moves a weight by about its learning rate per step, so that in some hundred steps weights this small have no effect;
    short recipes begin at 1."""
    label: Literal["predicted", "true", "probabilities"] = "predicted"
    """Label of the generator in training. Sec. 3.1, "this predicted label". Variants: the true one, and the predicted
    probabilities of all labels, in use, too: a condition of the instance, which Sec. 4.5 leaves to future work."""
    discriminators: int = Field(default=3, gt=0)
    """N_D. Sec. 3.1; Table 3 tries 1 to 4."""
    layers: int = Field(default=3, gt=0)
    """L, convolutions of stride 2 in each. Sec. 3.1; Table 3 tries 1 to 4."""
    width: int = Field(default=64, gt=0)
    """Channels after the first convolution of a discriminator. Table 2."""
    gain: float = Field(default=0.02, gt=0, allow_inf_nan=False)
    """Standard deviation of the initial weights. Sec. 3.2, "normal distribution with a gain of 0.02"."""

    match_bands: bool = False
    """After the training, fit the strength of the signals' bands, and its distribution over time, to recordings of the
    label (Heeger & Bergen 1995, see `tactogram.signal.band_levels`). Pictures are not changed. Ours."""
    l1: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the L1 loss. Sec. 3.1, lambda_L1."""
    feature_matching: float = Field(default=40.0, ge=0, allow_inf_nan=False)
    """Weight of the feature matching loss. Sec. 3.1, lambda_FM."""

    @model_validator(mode="after")
    def _bands_have_a_label(self) -> Self:
        if self.match_bands and not self.conditional:
            raise ValueError("match_bands needs the label, which conditional = false omits")
        return self
