"""Rule from images to words: cues from pixels, and the readiness with which each of ten words is evoked.

Simulated; docs/simulated-raters.md gives the source of each part. It depends on pixels alone, so photographs, simulated
and generated pictures are treated alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from PIL import Image as Pillow
from scipy.ndimage import black_tophat, gaussian_filter, white_tophat

from tactogram.datasets.ratings.words import WORDS
from tactogram.datasets.simulate.raters.felt import clip
from tactogram.signal import Image

SEEN_AT = 64
"""Pixels a side to which every image is scaled."""
BANDS = {"coarse": (2.0, 6.0), "middle": (6.0, 14.0), "fine": (14.0, 32.0)}
"""Cycles per image side."""


@dataclass(frozen=True)
class SightCues:
    """Visual cues of an image, 0 to 1 each."""

    # Contrast of luminance in `BANDS`: shading that reads as relief of that size.
    coarse: float
    middle: float
    fine: float
    irregular: float  # variety of directions and sizes of coarse and middle contrast: 0 stripes, 1 noise
    streaks: float  # alignment of the edges: 0 none, 1 all in one direction
    thin: float  # contrast in thin lines: spikes, needles, creases, hair
    gloss: float  # highlights: positive skewness of the finer bands, and bright colourless pixels
    light: float  # mean luminance
    colour: float  # mean saturation
    warm: float  # red against blue: 0 blue, 1 red


def sight_cues(image: Image) -> SightCues:
    """Return the cues of an image's central square, at `SEEN_AT` pixels a side."""
    rgb = _square(image)
    light = rgb @ np.array([0.2126, 0.7152, 0.0722])
    contrast = {name: _band(light, *band) for name, band in BANDS.items()}
    rms = {name: float(x.std()) for name, x in contrast.items()}
    gy, gx = np.gradient(gaussian_filter(light, 0.7))
    xx, yy, xy = (float(np.mean(a * b)) for a, b in ((gx, gx), (gy, gy), (gx, gy)))
    high, low, thin = rgb.max(2), rgb.min(2), _thin(light)
    return SightCues(
        coarse=clip(rms["coarse"] / 0.10),
        middle=clip(rms["middle"] / 0.10),
        fine=clip(rms["fine"] / 0.09),
        irregular=_irregular(contrast["coarse"] + contrast["middle"]),
        streaks=float(np.hypot(xx - yy, 2 * xy) / max(xx + yy, 1e-6)),
        thin=thin,
        gloss=_gloss(rgb, light, thin),
        light=clip(float(light.mean())),
        colour=clip(float(((high - low) / np.maximum(high, 0.05)).mean())),
        warm=clip(0.5 + float((rgb[..., 0] - rgb[..., 2]).mean())),
    )


def sight_words(cues: SightCues) -> NDArray[np.float64]:
    """Return the readiness of each word, logits, float64, shape (word,), in the order of `WORDS`."""
    c = cues
    matt, dark, wild = 1 - c.gloss, 1 - c.light, c.irregular * (1 - 0.7 * c.streaks)
    relief = 1 - (1 - c.coarse) * (1 - 0.8 * c.middle)
    soft = (1 - c.fine) * (1 - 0.7 * c.middle)
    even = (1 - c.fine) * (1 - c.middle) * (1 - 0.7 * c.coarse)
    words = {
        "dry": -2.8 + 3.0 * c.fine * (1 - c.coarse) * matt + 1.5 * matt * c.light + 0.8 * c.warm * matt * c.fine,
        "sleek": -2.8 + 4.2 * even + 0.9 * c.streaks * (1 - c.coarse) * (1 - c.thin) + 0.8 * c.gloss * (1 - c.fine),
        "slippery": -3.4 + 2.8 * even + 3.4 * c.gloss * (1 - 0.6 * c.fine) - 1.0 * c.colour * (1 - c.gloss),
        "rugged": -3.6 + 4.4 * relief * wild * (1 - 0.8 * c.gloss) + 1.5 * dark * relief * matt,
        "uneven": -3.2 + 3.2 * relief * (1 - 0.5 * c.streaks) + 1.8 * c.coarse * (1 - c.thin),
        "rough": -3.0 + 4.2 * c.fine * matt + 1.8 * c.middle * c.irregular * matt,
        "squishy": -3.0 + 2.2 * c.coarse * soft + 4.0 * c.colour * even + 2.4 * c.gloss * c.colour * soft,
        "prickle": -3.2 + 9.0 * c.thin * c.fine * c.irregular * (1 - 0.6 * c.coarse) + 1.2 * c.fine * matt,
        "sticky": -3.3 + 3.8 * c.gloss * (0.3 + 0.7 * c.colour) + 2.8 * c.colour * c.warm * soft + dark * c.gloss,
        "rustle": -4.0 + 4.0 * c.middle * wild + 1.5 * c.thin * matt + 1.2 * c.warm + 1.2 * c.light * wild * relief,
    }  # fmt: skip
    return np.array([words[word] for word in WORDS])


def _thin(light: NDArray[np.float64]) -> float:
    """Return how much an image shows few, thin lines: narrower than 3 pixels, curved across and straight along.

    Grain has narrow marks everywhere; needles and creases stand out, so the measure is the excess over 3.5 times the
    mean.
    """
    bright = white_tophat(light, 3)
    yy, xx, xy = (gaussian_filter(light, 1.0, order=order) for order in ((2, 0), (0, 2), (1, 1)))
    middle, half = np.abs(yy + xx) / 2, np.hypot((yy - xx) / 2, xy)
    straight = middle + half > 3 * np.abs(middle - half)
    lines = np.where(straight, np.maximum(bright, black_tophat(light, 3)), 0.0)
    stands_out = [max(float(np.percentile(x, 97.5) - 3.5 * x.mean()), 0.0) for x in (bright, lines)]
    return clip(float(np.sqrt(stands_out[0] * stands_out[1])) / 0.10)


def _gloss(rgb: NDArray[np.float64], light: NDArray[np.float64], thin: float) -> float:
    """Return the gloss of an image: skewed luminance and pale spots, both without structures thinner than a spot."""
    soft = gaussian_filter(light, 0.8)
    high, low = (gaussian_filter(x, 0.8) for x in (rgb.max(2), rgb.min(2)))
    pale = (high - low) < 0.5 * np.maximum(high, 0.05)
    spots = float(np.mean(pale & (soft > soft.mean() + 0.2)))
    detail = soft - gaussian_filter(light, 6.0)
    lopsided = max(float(scipy.stats.skew(detail.ravel())), 0.0) if detail.std() > 0.01 else 0.0
    return clip((0.35 * lopsided + 5 * spots) * (1 - 0.7 * thin))


def _irregular(contrast: NDArray[np.float64]) -> float:
    power = np.abs(np.fft.rfft2(contrast)) ** 2
    share = power / max(float(power.sum()), 1e-12)
    return clip(float(-(share * np.log(share + 1e-12)).sum()) / np.log(300.0))


def _square(image: Image) -> NDArray[np.float64]:
    """Return the middle square, 0 to 1, `SEEN_AT` pixels a side, each the mean of what it covers, (row, column, 3)."""
    pixels = image.pixels
    side = min(pixels.shape[:2])
    top, left = ((length - side) // 2 for length in pixels.shape[:2])
    square = Pillow.fromarray(np.ascontiguousarray(pixels[top : top + side, left : left + side]))
    seen = square if side == SEEN_AT else square.resize((SEEN_AT, SEEN_AT), Pillow.Resampling.BOX)
    return np.asarray(seen, np.float64) / 255


def _band(light: NDArray[np.float64], low: float, high: float) -> NDArray[np.float64]:
    """Return ``light`` between ``low`` and ``high`` cycles per side, windowed towards the edges."""
    count = len(light)
    window = np.hanning(count + 2)[1:-1]
    weight = np.outer(window, window)
    flat = (light - (light * weight).sum() / weight.sum()) * weight / np.sqrt(np.mean(weight**2))
    ky, kx = np.fft.fftfreq(count, 1 / count)[:, None], np.fft.rfftfreq(count, 1 / count)[None]
    k = np.hypot(ky, kx)
    return np.asarray(np.fft.irfft2(np.fft.rfft2(flat) * ((k >= low) & (k < high)), s=light.shape))
