"""Rules of simulated raters: ten words from cues of touch, out of physical quantities, and from cues of pixels.

Simulated; docs/simulated-raters.md gives the source of each part. Nothing here depends on a stimulus's name.

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

from tactogram.datasets import WORDS
from tactogram.signal import Image, weighted
from tactogram_simulate.touch import RATE, FingerSlide

PACINIAN_HZ = (40.0, 1000.0)
FLUTTER_HZ = (2.0, 40.0)
SEEN_AT = 64
"""Pixels a side to which every image is scaled."""
BANDS = {"coarse": (2.0, 6.0), "middle": (6.0, 14.0), "fine": (14.0, 32.0)}
"""Cycles per image side."""


@dataclass(frozen=True)
class TouchCues:
    """Tactile cues, each 0 to 1 except the level.

    The level is that of the whole second, unlike `tactogram.signal.perception.sensation_level_db`, which weighs the
    middle: a loop has none.
    """

    level_db: (
        float  # of the vibration above 40 Hz over the threshold of touch: 0 is a barely perceptible sine
    )
    fine: float  # pitch: 1 for content well above 150 Hz, 0 well below
    irregular: float  # number of spectral lines: 0 one sine, 1 noise
    impulsive: float  # dominance of single jolts: kurtosis 0 is 0, 60 is 1
    flutter: float  # slow movement of the skin, 2 to 40 Hz: 1 um is 0, 100 um is 1
    coarse: float  # relief that presses into the skin: 0.15 mm rms is 1
    steep: float  # slopes of the relief: 0.6 rms is 1
    friction: float  # a coefficient of 0.25 is 0, of 0.75 is 1
    catching: float  # slow variation of the friction: 0.15 rms is 1


def touch_cues(touched: FingerSlide) -> TouchCues:
    """Return the cues of a touch."""
    vibration = weighted(touched.skin, band=PACINIAN_HZ).samples.astype(np.float64)
    frequency, power = scipy.signal.periodogram(vibration, RATE)
    total = power.sum(0)
    share = total / max(float(total.sum()), 1e-12)
    lines = float(np.exp(-(share * np.log(share + 1e-12)).sum()))
    mean_hz = float((share * frequency).sum())
    slow, drag = (_slow(x) for x in (touched.skin.samples.astype(np.float64), touched.drag[None]))
    jolts = float(scipy.stats.kurtosis(vibration[0])) if vibration[0].std() > 0 else 0.0
    return TouchCues(
        level_db=float(10 * np.log10(max(2 * np.mean(vibration**2, axis=1).sum(), 1e-10))),
        fine=float(1 / (1 + np.exp(-(mean_hz - 150) / 35))),
        irregular=clip(np.log(lines) / np.log(200)),
        impulsive=clip(np.log1p(max(jolts, 0.0)) / np.log(61)),
        flutter=clip(np.log10(max(1e6 * slow, 1e-3)) / 2),
        coarse=clip(touched.relief_mm / 0.15),
        steep=clip(touched.steepness / 0.6),
        friction=clip((touched.friction - 0.25) / 0.5),
        catching=clip(drag / 0.15),
    )


def touch_words(cues: TouchCues, *, sensitivity_db: float = 0.0) -> NDArray[np.float64]:
    """Return the score of each word, 0 to 1, float64, shape (word,), in the order of `WORDS`.

    ``sensitivity_db`` is that of a person above the mean.
    """
    c = cues
    vibration = clip((c.level_db + sensitivity_db + 5) / 45)
    smooth = (1 - vibration) * (1 - 0.75 * c.coarse)
    middling = float(np.exp(-(((vibration - 0.35) / 0.22) ** 2)))
    words = {
        "dry": 0.08 + 0.8 * middling * (0.3 + 0.7 * c.fine) * (1 - 0.8 * c.coarse) * (1 - 0.7 * c.friction),
        "sleek": 0.03 + 0.85 * smooth * (1 - 0.45 * c.friction) * (1 - 0.5 * c.flutter),
        "slippery": 0.03 + 0.9 * smooth**1.3 * (1 - 0.6 * c.friction) * (1 - 0.6 * c.catching),
        "rugged": 0.03 + 0.8 * c.coarse * (0.35 + 0.65 * vibration) + 0.22 * c.flutter * vibration,
        "uneven": 0.03 + 0.75 * c.coarse + 0.30 * c.flutter,
        "rough": 0.03 + 0.85 * vibration * (0.55 + 0.45 * c.irregular) + 0.15 * c.coarse * c.steep,
        "squishy": 0.04 + 0.25 * c.flutter * (1 - c.coarse) + 0.10 * c.friction,
        "prickle": 0.03 + vibration * (0.25 * c.fine + 0.45 * c.impulsive + 0.45 * c.steep),
        "sticky": 0.03 + 0.65 * c.friction**1.2 * (1 - 0.5 * vibration) + 0.30 * c.catching,
        "rustle": 0.03 + 0.8 * vibration * c.irregular * (0.45 + 0.35 * c.coarse + 0.35 * c.impulsive),
    }
    return np.asarray(np.clip([words[word] for word in WORDS], 0.0, 1.0))


def _slow(x: NDArray[np.float64]) -> float:
    """Return the rms in `FLUTTER_HZ` of all rows together."""
    frequency, power = scipy.signal.periodogram(x, RATE)
    kept = (frequency >= FLUTTER_HZ[0]) & (frequency < FLUTTER_HZ[1])
    return float(np.sqrt(power[:, kept].sum() * (frequency[1] - frequency[0])))


def clip(x: float) -> float:
    """Return ``x`` limited to 0 to 1."""
    return float(np.clip(x, 0.0, 1.0))


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
