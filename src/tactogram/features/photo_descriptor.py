"""Photograph descriptor: colour and coarseness, independent of position."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal import Image

OCTAVES = 6
"""Octave bands of spatial frequency, from half the sampling rate down."""
DIRECTIONS = 4
"""Orientations of a band's power, sorted, so that turning the camera changes little."""
LUMA = np.array([0.2126, 0.7152, 0.0722])
"""Rec. 709."""
FLOOR = 1e-8
"""Added to powers of contrast, so that a plain surface has a level."""
SMALLEST = 8
"""Pixels of the shorter side."""


def check_photograph(image: Any) -> None:
    """Raise `ParameterError` for anything but a photograph that is large enough to be described."""
    if not isinstance(image, Image):
        raise ParameterError(f"condition 'image' must be an Image, got {type(image).__name__}")
    if min(image.size) < SMALLEST:
        raise ParameterError(
            f"a photograph must be at least {SMALLEST} x {SMALLEST} pixels, got {image.size[1]} x {image.size[0]}"
        )


def descriptor(image: Image) -> NDArray[np.float64]:
    """Return colour, contrast and spectrum of a photograph, float64, shape (feature,).

    Mean luminance (0..1), two mean colour differences over it, then 10 log10 of the power of relative contrast in
    octave bands of spatial frequency (per pixel), each in four orientations from weakest to strongest.
    """
    rgb = image.pixels.astype(np.float64) / 255
    luminance = rgb @ LUMA
    mean = luminance.mean()
    colour = (rgb.mean(axis=(0, 1)) - mean)[[0, 2]] / (mean + 1e-3)
    contrast = (luminance - mean) / (mean + 1e-3)
    rows, columns = contrast.shape
    window = np.hanning(rows + 2)[1:-1, None] * np.hanning(columns + 2)[None, 1:-1]
    window /= np.sqrt(np.mean(window**2))
    power = np.abs(np.fft.fft2(contrast * window)) ** 2 / (rows * columns) ** 2
    fy, fx = np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)[None, :]
    radius = np.hypot(fy, fx)
    octave = np.floor(-np.log2(np.maximum(radius, 1e-9) / 0.5)).astype(int)
    sector = np.floor((np.arctan2(fy, fx) % np.pi) / np.pi * DIRECTIONS + 0.5).astype(int) % DIRECTIONS
    levels = [
        sorted(power[(octave == band) & (sector == side)].sum() for side in range(DIRECTIONS))
        for band in range(OCTAVES)
    ]
    return np.concatenate([[mean], colour, 10 * np.log10(np.ravel(levels) + FLOOR)])
