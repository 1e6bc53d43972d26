"""The rule by which an image becomes words: cues from pixels, and how readily each of ten words is evoked.

Simulated; docs/simulated-raters.md says where each part comes from. It goes by pixels alone, so a photograph, a formula's
picture and what a network made are judged alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from scipy.ndimage import gaussian_filter
from scipy.stats import skew

from tactogram.datasets.words import WORDS
from tactogram.signal import Image

SEEN_AT = 64
"""Pixels a side at which every image is looked at."""
BANDS = {"coarse": (2.0, 6.0), "middle": (6.0, 14.0), "fine": (14.0, 32.0)}
"""Cycles per image side."""


@dataclass(frozen=True)
class SightCues:
    """What of an image counts, 0 to 1 each.

    Parameters
    ----------
    coarse, middle, fine : float
        Contrast of luminance in `BANDS`: shading that reads as relief of that size.
    streaks : float
        How much the edges lie one way: 0 no way, 1 all the same.
    gloss : float
        Highlights: positive skewness of the finer bands, and pixels that are much brighter than the rest and colourless.
    sharp : float
        How much contrast sits in few, steep edges: spikes, cracks, creases.
    dark : float
        1 - mean lightness.
    colour : float
        Mean saturation.
    warm : float
        Red against blue: 0 blue, 1 red.
    """

    coarse: float
    middle: float
    fine: float
    streaks: float
    gloss: float
    sharp: float
    dark: float
    colour: float
    warm: float


def sight_cues(image: Image) -> SightCues:
    """Return what counts of an image: its middle square, at `SEEN_AT` pixels a side."""
    rgb = _square(image)
    light = rgb @ np.array([0.2126, 0.7152, 0.0722])
    contrast = {name: _band(light, *band) for name, band in BANDS.items()}
    rms = {name: float(x.std()) for name, x in contrast.items()}
    detail = contrast["middle"] + contrast["fine"]
    gy, gx = np.gradient(gaussian_filter(light, 0.7))
    xx, yy, xy = (float(np.mean(a * b)) for a, b in ((gx, gx), (gy, gy), (gx, gy)))
    steep = np.hypot(gx, gy)
    high, low = rgb.max(2), rgb.min(2)
    saturation = (high - low) / np.maximum(high, 0.05)
    spots = float(np.mean((light > light.mean() + 0.35) & (saturation < 0.35)))
    lopsided = float(skew(detail.ravel())) if detail.std() > 0.004 else 0.0
    return SightCues(
        coarse=_clip(rms["coarse"] / 0.16),
        middle=_clip(rms["middle"] / 0.12),
        fine=_clip(rms["fine"] / 0.09),
        streaks=float(np.hypot(xx - yy, 2 * xy) / max(xx + yy, 1e-6)),
        gloss=_clip(0.25 * max(lopsided, 0.0) + 5 * spots),
        sharp=_clip((float(np.percentile(steep, 98)) / max(float(np.mean(steep)), 1e-3) - 2) / 4)
        * _clip(float(np.percentile(steep, 98)) / 0.12),
        dark=_clip(1 - float(light.mean())),
        colour=_clip(float(saturation.mean())),
        warm=_clip(0.5 + float((rgb[..., 0] - rgb[..., 2]).mean())),
    )


def sight_words(cues: SightCues) -> NDArray[np.float64]:
    """Return how readily each word is evoked, logits, float64, shape (word,), in the order of `WORDS`."""
    c = cues
    relief = 1 - (1 - c.coarse) * (1 - 0.8 * c.middle)
    even = (1 - c.fine) * (1 - c.middle) * (1 - 0.7 * c.coarse)
    grain = c.fine * (1 - 0.6 * c.gloss)
    words = {
        "dry": -2.6 + 3.0 * grain * (1 - c.coarse) + 1.6 * (1 - c.gloss) * (1 - c.dark) + 0.8 * c.warm * (1 - c.gloss),
        "sleek": -2.8 + 4.2 * even + 1.0 * c.streaks * (1 - c.coarse) + 0.8 * c.gloss * (1 - c.fine),
        "slippery": -3.2 + 3.0 * even + 3.2 * c.gloss * (1 - 0.6 * c.fine),
        "rugged": -3.4 + 3.6 * relief * (1 - c.streaks) + 2.0 * c.dark * relief + 1.0 * c.sharp - 1.0 * c.colour,
        "uneven": -3.0 + 4.6 * c.coarse * (1 - 0.5 * c.streaks) + 1.4 * c.middle * (1 - c.fine),
        "rough": -3.0 + 4.4 * c.fine * (1 - c.gloss) + 1.8 * c.middle,
        "squishy": -3.6 + 3.2 * c.coarse * (1 - c.fine) * (1 - c.sharp) + 2.2 * c.colour * (1 - c.fine) + 1.0 * c.gloss,
        "prickle": -3.6 + 4.2 * c.sharp + 2.4 * c.fine * c.sharp + 0.8 * c.streaks * c.fine,
        "sticky": -3.6 + 3.4 * c.gloss * (0.4 + 0.6 * c.colour) + 1.4 * c.colour * (1 - c.fine) + 1.0 * c.dark * c.gloss,
        "rustle": -3.4 + 2.4 * c.middle * (1 - c.streaks) + 2.6 * c.sharp * (1 - c.gloss) + 2.0 * c.fine * (1 - c.gloss),
    }  # fmt: skip
    return np.array([words[word] for word in WORDS])


def _square(image: Image) -> NDArray[np.float64]:
    """Return the middle square at `SEEN_AT` pixels a side, each the mean of what it covers, 0 to 1, (row, column, 3)."""
    pixels = image.pixels
    side = min(pixels.shape[:2])
    top, left = ((length - side) // 2 for length in pixels.shape[:2])
    square = Pillow.fromarray(np.ascontiguousarray(pixels[top : top + side, left : left + side]))
    seen = square if side == SEEN_AT else square.resize((SEEN_AT, SEEN_AT), Pillow.Resampling.BOX)
    return np.asarray(seen, np.float64) / 255


def _band(light: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """Return what of ``light`` is between ``low`` and ``high`` cycles per side; the middle is kept, the ends fade."""
    count = len(light)
    window = np.hanning(count + 2)[1:-1]
    weight = np.outer(window, window)
    flat = (light - (light * weight).sum() / weight.sum()) * weight / np.sqrt(np.mean(weight**2))
    ky, kx = np.fft.fftfreq(count, 1 / count)[:, None], np.fft.rfftfreq(count, 1 / count)[None]
    k = np.hypot(ky, kx)
    return np.asarray(np.fft.irfft2(np.fft.rfft2(flat) * ((k >= low) & (k < high)), s=light.shape))


def _clip(x: float) -> float:
    return float(np.clip(x, 0.0, 1.0))
