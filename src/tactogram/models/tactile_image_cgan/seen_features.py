"""Features of an image that its words depend on, differentiable: colour, highlights, and contrast by size."""

from __future__ import annotations

import torch
from torch import Tensor

from tactogram.features.photo_descriptor import LUMA

OCTAVES, FLOOR, DARK = 5, 1e-4, 0.05
"""Bands of spatial frequency, the last with all that is lower; power added to contrast; luminance added to its mean."""


def seen_features(images: Tensor) -> Tensor:
    """Return what is seen of images in -1 to 1, (item, 3, row, column), square -> (item, feature), differentiable.

    Mean red, green, blue and saturation, %, skewness of the luminance, tenths, positive where highlights are, and
    levels of contrast in octave bands, dB.
    """
    size, rgb = images.shape[-1], (images + 1) / 2
    saturation = (rgb.amax(1) - rgb.amin(1)) / rgb.amax(1).clamp_min(DARK)  # I, S, S
    light = torch.einsum("ichw,c->ihw", rgb, torch.from_numpy(LUMA).to(rgb))  # I, S, S
    contrast = light / (light.mean((1, 2), keepdim=True) + DARK)
    contrast = contrast - contrast.mean((1, 2), keepdim=True)
    skewness = contrast.pow(3).mean((1, 2)) / (contrast.square().mean((1, 2)) + FLOOR) ** 1.5  # I
    window = torch.hann_window(size + 2, periodic=False)[1:-1].to(rgb)
    window = window[:, None] * window / window.square().mean()
    power = torch.fft.fft2(contrast * window).abs().square() / size**4  # I, S, S
    along = torch.fft.fftfreq(size, device=rgb.device)
    octave = (-torch.log2(2 * torch.hypot(along[:, None], along))).floor().clamp(0, OCTAVES - 1)
    octave[0, 0] = OCTAVES  # the mean is in no band
    bands = torch.stack([power[:, octave == band].sum(1) for band in range(OCTAVES)], 1)  # I, band
    colour = torch.cat((rgb.mean((2, 3)), saturation.mean((1, 2))[:, None]), 1)  # I, 4
    return torch.cat((100 * colour, 10 * skewness[:, None], 10 * torch.log10(bands + FLOOR)), 1)
