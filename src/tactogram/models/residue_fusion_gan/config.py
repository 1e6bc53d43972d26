"""Numbers of a Residue-Fusion GAN. Its own paper is not available: Neshov et al. 2026, Sec. 2, describe it.

They describe a U-Net-style generator, into which feature maps of a DenseNet classifier are fed through a residue fusion
module; a single discriminator; WGAN-GP; feature matching and a perceptual loss of VGG-19. Everything else here is our
choice, marked "ours".
"""

from __future__ import annotations

from pydantic import Field, PositiveInt

from tactogram.nn.label_predictor import PredictorConfig
from tactogram.training.picture_learner import Beta, PictureConfig


class Config(PictureConfig):
    """Defaults are as described, or ours where nothing is."""

    predictor: PredictorConfig = PredictorConfig()
    """The classifier whose maps are fused: Neshov et al.'s label predictor, also a DenseNet. Ours."""
    widths: tuple[PositiveInt, ...] = Field(default=(64, 128, 256, 512, 512, 512, 512, 512), min_length=2)
    """Channels after each stage of the encoder: pix2pix's. Ours."""
    layers: int = Field(default=3, gt=0)
    """Convolutions of stride 2 in the critic. Ours."""
    width: int = Field(default=64, gt=0)
    """Channels after the critic's first convolution. Ours."""
    gain: float = Field(default=0.02, gt=0, allow_inf_nan=False)
    """Standard deviation of the initial weights. Ours."""
    penalty: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the gradient penalty. Gulrajani et al. 2017, Algorithm 1."""
    critic_updates: int = Field(default=5, gt=0)
    """Per generator update. Gulrajani et al. 2017, Algorithm 1."""
    feature_matching: float = Field(default=40.0, ge=0, allow_inf_nan=False)
    """Over the mean of the layers; pix2pixHD's weight. Ours."""
    perceptual: float = Field(default=10.0, ge=0, allow_inf_nan=False)
    """Weight of the perceptual loss, if ``vgg_weights`` names its network; pix2pixHD's. Ours."""
    vgg_weights: str = ""
    """torchvision's file of VGG-19; empty omits the perceptual loss."""
    learning_rate: float = Field(default=1e-4, gt=0, allow_inf_nan=False)
    """Of Adam. Gulrajani et al. 2017, Algorithm 1."""
    betas: tuple[Beta, Beta] = (0.0, 0.9)
    """Of Adam. Gulrajani et al. 2017, Algorithm 1."""
    epochs: int = Field(default=200, gt=0)
    """Neshov et al., Sec. 3.2; pairs of critic updates count, too."""
    constant: float = Field(default=1.0, ge=0, le=1)
    """Share of the training before the learning rate falls linearly to 0: never. Ours."""
    steps: int | None = Field(default=None, gt=0)
    """Generator updates, instead of ``epochs``. Ours."""
