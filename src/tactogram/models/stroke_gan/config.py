"""Configuration of the published network (Saga et al., Sec. III); the networks' numbers are in `WaveGANConfig`."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from tactogram.features.signal_crops import Epoch
from tactogram.training.wave_gan_learner import WaveGANConfig


class Config(WaveGANConfig):
    """Each number with its place in the paper; "assumed" where the paper gives none."""

    generator_updates: int = Field(default=2, gt=0)
    """Per step. Table IV, "Generator updates per discriminator: 2", read literally."""
    critic_updates: int = Field(default=1, gt=0)
    """Per step. WaveGAN and WGAN-GP update the critic more often than the generator, which Table IV may mean: the
    recipe ``variant-critic2``."""
    learning_rate: float = Field(default=1e-4, gt=0, allow_inf_nan=False)
    """Table IV, α of Adam."""
    epochs: int = Field(default=40, gt=0)
    """Sec. III-B, which does not define an epoch."""
    epoch_covers: Epoch = "recordings"
    """Crops of an epoch. Assumed. ``recordings``: one of each, and of a longer one one per whole length in it.
    ``slices``: one per whole length in each recording as repeated, as WaveGAN's program slices its files; the recipe
    ``variant-slices``. ``crops``: as many as a repeated recording has places to begin; ``variant-all-crops``."""
    steps: int | None = Field(default=None, gt=0)
    """Steps, instead of ``epochs``. Ours."""
    repetition: Literal["repeat", "crossfade"] = "repeat"
    """Extension of recordings shorter than the networks' length. ``repeat``: end to end, ten times (Sec. III-B), which
    jumps at each seam. ``crossfade``: joined to itself by crossfades, the recipe ``variant-crossfade``. Ours."""
    repetitions: int = Field(default=10, gt=0)
    """Of ``repeat``. Sec. III-B, "repeating each collected data 10 times"; more where ten are too short."""
    within_range: float = Field(default=1.0, gt=0, le=1)
    """Share of an axis's training samples within the range of tanh: 1 scales by the largest and clips nothing. Assumed:
    the paper does not say how it scaled."""
    whitening: int = Field(default=0, ge=0)
    """Order of the autoregressive filter, one for all materials, that recordings pass before the scale, and signals
    backwards. Ours; 0, the paper's, is none. Strokes fall by 40 dB from 50 to 300 Hz, and a short training learns what
    is strongest: the recipe ``variant-whitened``."""
