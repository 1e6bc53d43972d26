"""Layer sizes, from a photograph's square maps to a spectrogram's tall ones."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from operator import mul
from typing import Protocol

Size = tuple[int, int]
"""Rows (frequency, or down the photograph) and columns (displacement, or along it)."""


class SizeConfig(Protocol):
    """Configuration values that decide layer sizes."""

    @property
    def pixels(self) -> int: ...
    @property
    def bins(self) -> int: ...
    @property
    def frames(self) -> int: ...
    @property
    def strides(self) -> Sequence[int]: ...
    @property
    def up_strides(self) -> Sequence[int]: ...
    @property
    def wide(self) -> int: ...
    @property
    def match(self) -> str: ...


def encoder_sizes(config: SizeConfig) -> list[int]:
    """Return the side of each map of the encoder: 512, 256, 128, 64, 32, 8, 2 as published."""
    return [config.pixels // product for product in accumulate(config.strides, mul)]


def decoder_sizes(config: SizeConfig) -> list[Size]:
    """Return the sizes of the decoder's input and of each layer's output.

    Backwards from the spectrogram, each is the output size of a strided convolution with padding "same" of the next, as
    in the critic: (3, 3), (9, 3), (33, 3), (65, 3), (129, 6), (257, 11).
    """
    sizes = [(config.bins, config.frames)]
    for rows, columns in reversed(column_strides(config)):
        sizes.append((-(-sizes[-1][0] // rows), -(-sizes[-1][1] // columns)))
    return sizes[::-1]


def column_strides(config: SizeConfig) -> list[Size]:
    """Return the stride of each decoder layer, along frequency and along displacement."""
    last = len(config.up_strides) - config.wide
    return [(stride, 2 if layer >= last else 1) for layer, stride in enumerate(config.up_strides)]


def critic_size(size: Size) -> Size:
    """Return the size of the critic's output for a spectrogram of ``size``: (257, 11) to (30, 1)."""
    rows, columns = size
    for down, across in ((2, 2), (2, 2), (2, 1)):
        rows, columns = -(-rows // down), -(-columns // across)
    return rows + 2 - 4 + 2 - 3, columns + 2 - 3 + 2 - 3


def check(config: SizeConfig) -> None:
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
