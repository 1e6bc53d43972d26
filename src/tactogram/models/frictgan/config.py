"""Configuration of FrictGAN: every number with its place; "open" where the paper states none."""

from __future__ import annotations

import math
from itertools import accumulate
from operator import mul
from typing import Literal, Self

from pydantic import Field, PositiveInt, model_validator

from tactogram.features.registered_pairs import PhotoWindows, Protocol
from tactogram.features.spectrogram import AmplitudeSpectrogram
from tactogram.model import ModelConfig


class Config(ModelConfig):
    """FrictGAN; the defaults are the paper's.

    "Code" is the authors' first public repository, "later code" their second (of the paper's successor); both differ
    from the paper and from each other, see README.
    """

    # -- pairs
    pixels: PositiveInt = 1024
    """Sec. 4: "1024x1024 sliding window"."""
    offset: PositiveInt = 2
    """Sec. 4: "the offset of two pixels"."""
    windows: PositiveInt | None = 600
    """Sec. 4: "the previous 600 pairs" of each photograph; None takes all."""
    protocol: Protocol = "window-split"
    """Sec. 4: 100 + 100 "randomly selected" overlapping windows, which leaks; the other two are ours."""
    shares: tuple[float, float, float] = (400 / 600, 100 / 600, 100 / 600)
    """Sec. 4: 2000, 500, 500 pairs of five fabrics."""
    grey: bool = False
    """Sec. 3.1: 1024 x 1024 x 3; the later code has one channel."""
    # -- spectrogram
    n_fft: int = Field(default=512, ge=4)
    """Sec. 4: "512-hamming window"."""
    hop: PositiveInt = 128
    """Sec. 4: "128-hop size"."""
    frames: int = Field(default=11, ge=4)
    """Sec. 3.1: 257 x 11."""
    nonnegative: bool = True
    """Whether signals are >= 0, as friction coefficients are. The code takes the absolute value of its output."""
    iterations: int = Field(default=32, ge=0)
    """Of Griffin-Lim; open in the paper; the code has librosa's default."""
    scale: Literal["none", "bins", "log"] = "none"
    """Magnitudes in the networks: unscaled (the code's files; open in the paper); or (ours) divided by each frequency's
    mean over the training part, so that the mean level, some hundred times the ripple, does not dominate the L1
    distance; or log(1 + 100 x) of such a quotient x, so that smooth fabrics count, too."""
    # -- generator
    channels: tuple[PositiveInt, ...] = (32, 64, 128, 256, 512, 512, 512)
    """Encoder; open in the paper; the code's."""
    strides: tuple[PositiveInt, ...] = (2, 2, 2, 2, 2, 4, 4)
    """Encoder; open in the paper; the code's."""
    up_strides: tuple[Literal[2, 4], ...] = (4, 4, 2, 2, 2)
    """Decoder, along frequency; the last ones also along displacement. Open in the paper."""
    wide: int = Field(default=2, ge=0)
    """Last decoder layers that also double the number of frames. Open in the paper."""
    latent: int = Field(default=128, ge=0)
    """Sec. 3.1: "a 128-dimensional latent vector"; 0 keeps the bottleneck a map (code)."""
    noise: int = Field(default=50, ge=0)
    """Sec. 3.1: "a random 50-dimensional noise vector"; 0 omits it (code)."""
    dropout: float = Field(default=0.5, ge=0, lt=1)
    """Share; open in the paper; the code's."""
    encoder_dropout: int = Field(default=3, ge=0)
    """Sec. 3.1: "in the last three layers of the encoder"."""
    decoder_dropout: int = Field(default=0, ge=0)
    """First decoder layers with dropout; the later code has three there and none in the encoder."""
    match: Literal["crop", "pool"] = "crop"
    """Resizing of a square map of the photograph to one of the spectrogram: its middle (Sec. 3.1: "cropped texture
    image"; the code also crops in the skip connections), or (ours) means over areas, which preserve the whole
    photograph and its left-to-right order."""
    first_norm: bool = True
    """Whether the first layers of generator and critic are normalised: "each layer" (Sec. 3.1); not so in the code."""
    # -- critic
    critic_channels: tuple[PositiveInt, PositiveInt, PositiveInt, PositiveInt] = (64, 128, 256, 512)
    """PatchGAN (Sec. 3.1): 257 x 11 x 4 to 30 x 1; channels are the code's, and pix2pix's."""
    leak: float = 0.2
    """Of LeakyReLU; open in the paper; the code's."""
    # -- training
    loss: Literal["wasserstein", "cross-entropy"] = "wasserstein"
    """Eq. (2); both repositories have the sigmoid cross-entropy, with weights clipped all the same."""
    l1: float = Field(default=100.0, ge=0)
    """Sec. 3.2: lambda."""
    adversarial: float = Field(default=1.0, ge=0)
    """Eq. (3): 1; 0 omits the critic (ours, to see its effect)."""
    clip: float = Field(default=0.01, gt=0)
    """Largest weight of the critic; open in the paper; WGAN's (Arjovsky et al. 2017, Algorithm 1) and the code's."""
    critic_updates: PositiveInt = 5
    """Per generator update; open in the paper; that of WGAN and the code."""
    learning_rate: float = Field(default=5e-5, gt=0)
    """Sec. 4, RMSprop."""
    critic_learning_rate: float | None = Field(default=None, gt=0)
    """None is ``learning_rate``, as in Sec. 4."""
    constant: float = Field(default=1.0, ge=0, le=1)
    """Share of the updates after which the learning rates fall linearly, to 0 at the end; 1 (open in the paper; the
    code's) keeps them. RMSprop steps of a constant size leave the level wherever the last batches pushed it."""
    batch_size: int = Field(default=2, ge=2)
    """Sec. 4."""
    epochs: int = Field(default=400, gt=0)
    """Open in the paper; the code's."""
    steps: int | None = Field(default=None, gt=0)
    """Generator updates; None follows from ``epochs``."""
    # -- use
    playback_rate: float = Field(default=4000.0, gt=0)
    """Rate in Hz of a signal played at a speed; ours."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if len(self.channels) != len(self.strides):
            raise ValueError("channels and strides must be equally many")
        if len(self.up_strides) > len(self.strides):
            raise ValueError("up_strides must not be more than strides: each has a skip connection")
        if self.pixels % math.prod(self.strides):
            raise ValueError(
                f"pixels must be a multiple of the product of strides, {math.prod(self.strides)}"
            )
        if self.noise and not self.latent:
            raise ValueError("noise joins the latent vector: latent must be > 0, or noise 0")
        self.spectrogram(), self.photo_windows()  # refuse invalid fields
        check(self)
        return self

    @property
    def window_protocol(self) -> str:
        """Protocol that splits windows of the training data; empty if recordings are split."""
        return "" if self.protocol == "examples" else self.protocol

    @property
    def bins(self) -> int:
        """Rows of a spectrogram."""
        return self.n_fft // 2 + 1

    def spectrogram(self) -> AmplitudeSpectrogram:
        """Return the spectrogram of a window."""
        return AmplitudeSpectrogram(
            n_fft=self.n_fft,
            hop=self.hop,
            frames=self.frames,
            nonnegative=self.nonnegative,
            iterations=self.iterations,
        )

    def photo_windows(self) -> PhotoWindows:
        """Return how windows are cut."""
        return PhotoWindows(
            pixels=self.pixels,
            samples=(self.frames - 1) * self.hop,
            offset=self.offset,
            most=self.windows,
            protocol=self.protocol,
            shares=self.shares,
            grey=self.grey,
        )


Size = tuple[int, int]
"""Rows (frequency, or down the photograph) and columns (displacement, or along it)."""


def encoder_sizes(config: Config) -> list[int]:
    """Return the side of each map of the encoder: 512, 256, 128, 64, 32, 8, 2 as published."""
    return [config.pixels // product for product in accumulate(config.strides, mul)]


def decoder_sizes(config: Config) -> list[Size]:
    """Return the sizes of the decoder's input and of each layer's output.

    Backwards from the spectrogram, each is the output size of a strided convolution with padding "same" of the next, as
    in the critic: (3, 3), (9, 3), (33, 3), (65, 3), (129, 6), (257, 11).
    """
    sizes = [(config.bins, config.frames)]
    for rows, columns in reversed(column_strides(config)):
        sizes.append((-(-sizes[-1][0] // rows), -(-sizes[-1][1] // columns)))
    return sizes[::-1]


def column_strides(config: Config) -> list[Size]:
    """Return the stride of each decoder layer, along frequency and along displacement."""
    last = len(config.up_strides) - config.wide
    return [(stride, 2 if layer >= last else 1) for layer, stride in enumerate(config.up_strides)]


def critic_size(size: Size) -> Size:
    """Return the size of the critic's output for a spectrogram of ``size``: (257, 11) to (30, 1)."""
    rows, columns = size
    for down, across in ((2, 2), (2, 2), (2, 1)):
        rows, columns = -(-rows // down), -(-columns // across)
    return rows + 2 - 4 + 2 - 3, columns + 2 - 3 + 2 - 3


def check(config: Config) -> None:
    """Refuse sizes that do not fit together."""
    if min(critic_size((config.bins, config.frames))) < 1:
        raise ValueError(
            f"n_fft must be at least 64 and frames at least 9 for the critic to have a patch, got {config.bins} bins "
            f"and {config.frames} frames"
        )
    if config.match == "crop":
        kept = encoder_sizes(config)[: len(config.up_strides)]
        for side, size in zip(kept, reversed(decoder_sizes(config)[1:]), strict=True):
            if side < max(size):
                raise ValueError(
                    f"a map of {side} x {side} cannot be cropped to {size[0]} x {size[1]}: raise pixels, "
                    "or set match = 'pool'"
                )
