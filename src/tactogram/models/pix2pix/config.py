"""Configuration of Isola et al. 2017, numbers with their places; pairs and schedule are those of Neshov et al. 2026."""

from __future__ import annotations

from pydantic import Field, PositiveInt

from tactogram.training.picture_learner import Beta, PictureConfig


class Config(PictureConfig):
    """Defaults are the papers'."""

    widths: tuple[PositiveInt, ...] = Field(default=(64, 128, 256, 512, 512, 512, 512, 512), min_length=2)
    """Channels after each stage of the encoder. Sec. 6.1.1, "C64-C128-C256-C512-C512-C512-C512-C512"."""
    dropout: int = Field(default=3, ge=0)
    """Stages of the decoder with dropout of 50 %. Sec. 6.1.1, "CD512-CD512-CD512-…"."""
    layers: int = Field(default=3, gt=0)
    """Convolutions of stride 2 in the discriminator: patches of 70 x 70. Sec. 6.1.2."""
    width: int = Field(default=64, gt=0)
    """Channels after the discriminator's first convolution. Sec. 6.1.2, "C64-C128-C256-C512"."""
    gain: float = Field(default=0.02, gt=0, allow_inf_nan=False)
    """Standard deviation of the initial weights. Sec. 6.2."""
    l1: float = Field(default=100.0, ge=0, allow_inf_nan=False)
    """Weight of the L1 loss. Sec. 4.2, lambda = 100."""
    batch_size: int = Field(default=32, gt=1)
    """Neshov et al., Sec. 3.2. Isola et al. take 1 to 10 (Sec. 6.2)."""
    learning_rate: float = Field(default=2e-4, gt=0, allow_inf_nan=False)
    """Of Adam. Sec. 3.3."""
    betas: tuple[Beta, Beta] = (0.5, 0.999)
    """Of Adam. Sec. 3.3."""
    epochs: int = Field(default=200, gt=0)
    """Sec. 6.2, and Neshov et al."""
    constant: float = Field(default=0.5, ge=0, le=1)
    """Share of the training before the learning rate falls linearly to 0. The authors' PyTorch code, and
    Neshov et al."""
