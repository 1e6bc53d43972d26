"""Configuration of Wang et al. 2018, numbers with their places; pairs and schedule are those of Neshov et al. 2026."""

from __future__ import annotations

from pydantic import Field

from tactogram.nn.adversarial_networks import LossKind
from tactogram.training.picture_learner import Beta, PictureConfig


class Config(PictureConfig):
    """Defaults are the papers'."""

    generator_width: int = Field(default=64, gt=0)
    """Channels after the first convolution. Sec. 9 (appendix), "c7s1-64"."""
    downsamplings: int = Field(default=4, gt=0)
    """Sec. 9, "d128, d256, d512, d1024"."""
    blocks: int = Field(default=9, gt=0)
    """Residual blocks. Sec. 9, nine "R1024"."""
    discriminators: int = Field(default=3, gt=0)
    """Sec. 3.2, "3 discriminators"."""
    layers: int = Field(default=3, gt=0)
    """Convolutions of stride 2 in each. Sec. 9, "C64-C128-C256-C512": the fourth has stride 1 in the authors' code."""
    width: int = Field(default=64, gt=0)
    """Channels after the first convolution of a discriminator. Sec. 9."""
    gain: float = Field(default=0.02, gt=0, allow_inf_nan=False)
    """Standard deviation of the initial weights. Sec. 4, "Gaussian distribution with mean 0 and … 0.02"."""
    adversarial: LossKind = "least-squares"
    """Sec. 4, "LSGANs for stable training"."""
    feature_matching: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the sum over layers (times 4 / (L + 1)). Sec. 3.2, Eq. 5, and Sec. 4, lambda = 10. Neshov et al.'s 40
    over the mean of the layers is the same weight."""
    perceptual: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the perceptual loss, if ``vgg_weights`` names its network. Sec. 3.2; 10 in the authors' code."""
    vgg_weights: str = ""
    """torchvision's file of VGG-19; empty omits the perceptual loss ("pix2pixHD w/o VGG loss", Sec. 4)."""
    learning_rate: float = Field(default=2e-4, gt=0, allow_inf_nan=False)
    """Of Adam. Sec. 4."""
    betas: tuple[Beta, Beta] = (0.5, 0.999)
    """Of Adam. The authors' code."""
    epochs: int = Field(default=200, gt=0)
    """Sec. 4, 100 and then 100 more."""
    constant: float = Field(default=0.5, ge=0, le=1)
    """Share of the training before the learning rate falls linearly to 0. Sec. 4."""
