"""Square crops of photographs, augmented, for image networks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from torch import Tensor

from tactogram.errors import ParameterError
from tactogram.signal import Image

LUMA = (0.299, 0.587, 0.114)
"""Red, green and blue in grey: ITU-R BT.601, as in Pillow and torchvision."""


@dataclass(frozen=True, kw_only=True)
class PhotoCrops:
    """Crops of photographs; defaults are the paper's (Neshov et al. 2026, Sec. 4.1, "Visual Data")."""

    crop: int = 256
    """Side of the square cut from a photograph, pixels."""
    size: int = 256
    """Side of the network's input, pixels, at most ``crop``, which is averaged down."""
    grayscale: bool = True
    """One channel (ITU-R BT.601), or three."""
    per_photo: int = 10
    per_recording: int = 10
    """Random crops of each recording, as ``per_photo`` of each photograph."""
    repeats: int = 10
    """Random pairings of all crops of a material."""
    flips: bool = True
    """Left to right and top to bottom, each with probability 1/2."""
    brightness: float = 0.2
    contrast: float = 0.2
    """``brightness`` and ``contrast`` change by a factor drawn evenly from 1 - x to 1 + x, as in torchvision's
    ``ColorJitter``. The paper states no amount."""

    def __post_init__(self) -> None:
        for name in ("crop", "size", "per_photo", "per_recording", "repeats"):
            value = getattr(self, name)
            if not (isinstance(value, int) and value >= 1):
                raise ParameterError(f"{name} must be a whole number >= 1, got {value}")
        if self.size > self.crop:
            raise ParameterError.must("size", f"be <= crop ({self.crop} pixels)", self.size)
        for name in ("brightness", "contrast"):
            if not 0 <= getattr(self, name) <= 1:
                raise ParameterError(f"{name} must be in 0..1, got {getattr(self, name)}")

    def check(self, rows: int, columns: int) -> None:
        """Refuse a photograph smaller than a crop."""
        if min(rows, columns) < self.crop:
            raise ParameterError(
                f"a photograph (or the region of it that this part may use) of {rows} x {columns} pixels is "
                f"smaller than the crop of {self.crop}: take a smaller crop"
            )

    def place(self, rows: int, columns: int, rng: np.random.Generator) -> tuple[int, int]:
        """Return top and left of a random crop of a photograph of ``rows`` x ``columns`` pixels."""
        self.check(rows, columns)
        return int(rng.integers(rows - self.crop + 1)), int(rng.integers(columns - self.crop + 1))

    def random(self, image: Image, rng: np.random.Generator) -> NDArray[np.uint8]:
        """Return a random crop, augmented: uint8, shape (channel, size, size). Draws `place` from ``rng`` first."""
        top, left = self.place(*image.size, rng)
        pixels = image.pixels[top : top + self.crop, left : left + self.crop]
        left_right, top_bottom = rng.random(2) < 0.5
        if self.flips and left_right:
            pixels = pixels[:, ::-1]
        if self.flips and top_bottom:
            pixels = pixels[::-1]
        factors = 1 + rng.uniform(-1, 1, 2) * (self.brightness, self.contrast)
        # Contiguous rows of one colour each are several times faster than interleaved pixels.
        colours = np.ascontiguousarray(pixels.transpose(2, 0, 1), dtype=np.float32)  # 3, row, column
        if factors[0] != 1:
            np.clip(colours * np.float32(factors[0]), 0, 255, out=colours)
        if factors[1] != 1:
            mean = np.float32((1 - factors[1]) * _grey(colours).mean())
            np.clip(colours * np.float32(factors[1]) + mean, 0, 255, out=colours)
        channels = _grey(colours)[None] if self.grayscale else colours
        if self.size < self.crop:
            size = (self.size, self.size)
            channels = F.interpolate(torch.from_numpy(channels)[None], size, mode="area")[0].numpy()
        return np.rint(channels).astype(np.uint8)


def to_network(pixels: NDArray[np.uint8]) -> Tensor:
    """Return uint8 pixels of any shape as float32 in [-1, 1]: 0 is -1, 255 is 1."""
    return torch.from_numpy(pixels).to(torch.float32).div_(127.5).sub_(1)


def _grey(colours: NDArray[np.float32]) -> NDArray[np.float32]:
    grey: NDArray[np.float32] = np.tensordot(np.array(LUMA, np.float32), colours, 1)
    return grey
