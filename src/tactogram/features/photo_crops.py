"""Square crops of photographs, augmented, as an image network takes them."""

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
"""Red, green and blue in grey: ITU-R BT.601, as Pillow and torchvision have it."""


@dataclass(frozen=True, kw_only=True)
class PhotoCrops:
    """Crops of photographs; defaults are the paper's (Neshov et al. 2026, Sec. 4.1, "Visual Data").

    Parameters
    ----------
    crop : int, pixels
        Side of the square that is cut from a photograph.
    size : int, pixels
        Side of what the network gets: ``crop`` averaged down where it is smaller.
    grayscale : bool
        One channel (ITU-R BT.601), or three.
    per_photo, per_recording : int
        Random crops of each photograph, and of each recording.
    repeats : int
        How often all crops of a material are paired anew.
    flips : bool
        Left to right and top to bottom, each with probability 1/2.
    brightness, contrast : float, 0..1
        Each by a factor drawn evenly from 1 - x to 1 + x, as torchvision's ``ColorJitter`` does. The paper names
        no amount.

    Raises
    ------
    ParameterError
        If a field is not what it should be.
    """

    crop: int = 256
    size: int = 256
    grayscale: bool = True
    per_photo: int = 10
    per_recording: int = 10
    repeats: int = 10
    flips: bool = True
    brightness: float = 0.2
    contrast: float = 0.2

    def __post_init__(self) -> None:
        for name in ("crop", "size", "per_photo", "per_recording", "repeats"):
            value = getattr(self, name)
            if not (isinstance(value, int) and value >= 1):
                raise ParameterError(f"{name} must be a whole number >= 1, got {value}")
        if self.size > self.crop:
            raise ParameterError(f"size must be <= crop ({self.crop} pixels), got {self.size}")
        for name in ("brightness", "contrast"):
            if not 0 <= getattr(self, name) <= 1:
                raise ParameterError(f"{name} must be in 0..1, got {getattr(self, name)}")

    @property
    def channels(self) -> int:
        """1 or 3."""
        return 1 if self.grayscale else 3

    def check(self, rows: int, columns: int) -> None:
        """Refuse a photograph that no crop fits into.

        Raises
        ------
        ParameterError
            Naming both sizes.
        """
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
        """Return a random crop, augmented: cut, flip, brightness, contrast, grey, size.

        Parameters
        ----------
        image : Image
        rng : numpy Generator
            `place` is drawn from it first.

        Returns
        -------
        uint8 array, shape (channel, size, size)

        Raises
        ------
        ParameterError
            If the photograph is smaller than the crop.
        """
        pixels = self._cut(image, *self.place(*image.size, rng))
        left_right, top_bottom = rng.random(2) < 0.5
        if self.flips and left_right:
            pixels = pixels[:, ::-1]
        if self.flips and top_bottom:
            pixels = pixels[::-1]
        factors = 1 + rng.uniform(-1, 1, 2) * (self.brightness, self.contrast)
        # As contiguous rows of one colour each: several times faster than pixel by pixel.
        colours = np.ascontiguousarray(pixels.transpose(2, 0, 1), dtype=np.float32)  # 3, row, column
        if factors[0] != 1:
            np.clip(colours * np.float32(factors[0]), 0, 255, out=colours)
        if factors[1] != 1:
            mean = np.float32((1 - factors[1]) * _grey(colours).mean())
            np.clip(colours * np.float32(factors[1]) + mean, 0, 255, out=colours)
        return self._finished(colours)

    def centre(self, image: Image) -> Tensor:
        """Return the middle of a photograph, not augmented, as a network takes it.

        Returns
        -------
        float32 tensor, shape (channel, size, size), in [-1, 1]

        Raises
        ------
        ParameterError
            If the photograph is smaller than the crop.
        """
        rows, columns = image.pixels.shape[:2]
        self.check(rows, columns)
        pixels = self._cut(image, (rows - self.crop) // 2, (columns - self.crop) // 2)
        return to_network(self._finished(np.ascontiguousarray(pixels.transpose(2, 0, 1), dtype=np.float32)))

    def _cut(self, image: Image, top: int, left: int) -> NDArray[np.uint8]:
        return image.pixels[top : top + self.crop, left : left + self.crop]

    def _finished(self, colours: NDArray[np.float32]) -> NDArray[np.uint8]:
        """Return colours (3, row, column) in 0..255 as uint8 of the network's channels and size."""
        kept = _grey(colours)[None] if self.grayscale else colours
        if self.size < self.crop:
            size = (self.size, self.size)
            kept = F.interpolate(torch.from_numpy(kept)[None], size, mode="area")[0].numpy()
        return np.rint(kept).astype(np.uint8)


def to_network(pixels: NDArray[np.uint8]) -> Tensor:
    """Return uint8 pixels of any shape as float32 in [-1, 1]: 0 is -1, 255 is 1."""
    return torch.from_numpy(pixels).to(torch.float32).div_(127.5).sub_(1)


def _grey(colours: NDArray[np.float32]) -> NDArray[np.float32]:
    grey: NDArray[np.float32] = np.tensordot(np.array(LUMA, np.float32), colours, 1)
    return grey
