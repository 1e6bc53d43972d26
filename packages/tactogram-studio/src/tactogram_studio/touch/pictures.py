"""Pad pictures of the page Touch: a material's photograph, or the signal drawn as a surface."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Literal
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from tactogram.rendering import combined
from tactogram.signal import Image, Signal, over_displacement
from tactogram_playback import looped
from tactogram_studio.touch.sources import TextureRequest, TouchSources
from tactogram_studio.touch.tables import ASSUMED_SPEED_MM_S

Array = NDArray[np.float64]
Kind = Literal["photograph", "rendered", "drawn"]

MM_PER_PIXEL = 0.15
ROWS, COLUMNS, MOST_COLUMNS = 256, 640, 4000
ACROSS_MM = 1.2
"""Correlation length between lines of a drawn surface; a finger's ridges are about half of that apart."""
WAVY, REPEATS = 0.3, 0.5
"""Deviation of drawn ridges as a share of their period; least autocorrelation of a line with ridges."""
QUALITY = 80
"""Of WebP, 0 to 100: a lossless picture has six times the size."""
LIGHT = np.array([196.0, 187.0, 174.0])
"""Colour of a drawn surface, sRGB: paper, so that nobody mistakes it for a photograph."""


@dataclass(frozen=True, eq=False)
class PadPicture:
    """A picture for the pad: a photograph, a rendered picture of a simulated surface, or one drawn from the signal.

    Without ``mm_per_pixel`` it fills the pad; ``words`` describe it for screen readers. ``line`` is the row that is
    felt, as a share of the height, where the surface is drawn from a photograph.
    """

    webp: bytes
    kind: Kind
    mm_per_pixel: float | None
    words: str
    line: float | None = None

    def headers(self) -> dict[str, str]:
        """Return the headers of an answer with this picture, as the page reads them."""
        scale = {} if self.mm_per_pixel is None else {"X-Mm-Per-Pixel": f"{self.mm_per_pixel:.6g}"}
        line = {} if self.line is None else {"X-Line": f"{self.line:.6g}"}
        return {"X-Picture": self.kind, "X-Words": quote(self.words), **scale, **line}


def picture_of(sources: TouchSources, request: TextureRequest) -> PadPicture:
    """Return a photograph of the texture, or its signal drawn as a surface; errors as of `TouchSources.table`."""
    name = sources.title(request)
    photograph = sources.photograph(request)
    if photograph is not None:
        image, simulated = photograph
        kind: Kind = "rendered" if simulated else "photograph"
        words = f"{name}: rendered picture of the simulated surface" if simulated else f"Photograph of {name}"
        if request.where == "kept":
            shown = _reduced(image)
            return PadPicture(_webp(shown.pixels), kind, shown.mm_per_pixel, f"Photograph {name}", line=0.5)
        return PadPicture(_webp(image.pixels), kind, image.mm_per_pixel, words)
    signal, speed = sources.signal(request)
    drawn = drawn_surface(signal, speed or ASSUMED_SPEED_MM_S, registered=request.lay in ("x", "y"))
    pixels = drawn.pixels.transpose(1, 0, 2) if request.lay == "y" else drawn.pixels
    return PadPicture(
        _webp(pixels), "drawn", drawn.mm_per_pixel, f"{name}: drawn from the signal, no photograph"
    )


def _reduced(image: Image) -> Image:
    """Return a photograph of at most `MOST_COLUMNS` / 2 pixels on its longer side, enough for a screen."""
    picture = Pillow.fromarray(image.pixels)
    picture.thumbnail((MOST_COLUMNS // 2, MOST_COLUMNS // 2))
    scale = image.mm_per_pixel and image.mm_per_pixel * image.size[1] / picture.width
    return Image(np.asarray(picture), scale)


def drawn_surface(signal: Signal, speed_mm_s: float, *, registered: bool = False) -> Image:
    """Return a signal as a relief lit from the left: its values are heights along the stroke.

    A signal over time is laid out at ``speed_mm_s``. If ``registered``, every line is the loop that is played, at most
    4000 pixels, so that picture and texture match in position. Otherwise ridges deviate a little; without ridges, lines
    start at random positions and neighbours correlate over `ACROSS_MM`.
    """
    steady = signal.samples - signal.samples.mean(axis=1, keepdims=True)
    profile, _ = combined(signal.with_samples(steady), "dft321" if len(signal.axes) <= 3 else signal.axes[0])
    if profile.domain == "time":
        profile = over_displacement(profile, speed_mm_s)
    line = _at_pixels(looped(profile) if registered else profile)
    if registered:
        height = np.broadcast_to(line[:MOST_COLUMNS], (ROWS, min(len(line), MOST_COLUMNS)))
    else:
        line = np.tile(line, -(-COLUMNS // len(line)))
        random = np.random.default_rng(0)
        period = _period(line)
        if period:  # ridges: one after the other, a little wavy
            wander = np.cumsum(random.standard_normal(ROWS))
            wander = np.convolve(wander, np.hanning(41) / np.hanning(41).sum(), mode="same")
            starts = np.round(WAVY * period * wander / max(1.0, float(np.abs(wander).max()))).astype(int)
        else:
            starts = random.integers(0, len(line), ROWS)
        height = line[(starts[:, None] + np.arange(COLUMNS)) % len(line)]
        height = height if period else _smooth_down(height, ACROSS_MM / MM_PER_PIXEL)
    return Image(_lit(height), mm_per_pixel=MM_PER_PIXEL)


def _at_pixels(signal: Signal) -> Array:
    """Return the signal's values one pixel apart, with variance 1."""
    step = MM_PER_PIXEL * signal.rate
    values = signal.samples[0].astype(np.float64)
    if step > 1:  # means over a pixel prevent aliasing
        count = max(1, int(len(values) / step))
        edges = (np.arange(count + 1) * step).astype(int)
        line = np.add.reduceat(values, edges[:-1]) / np.diff(edges)
    else:
        line = np.interp(np.arange(0, len(values), step), np.arange(len(values)), values)
    spread = float(line.std())
    return line / spread if spread > 0 else line


def _period(line: Array) -> int:
    """Return the period of a line in pixels, up to 15 mm; 0 if it has none."""
    power = np.abs(np.fft.rfft(line - line.mean(), 2 * len(line))) ** 2
    correlation = np.fft.irfft(power)[: min(len(line) // 2, round(15 / MM_PER_PIXEL))]
    if len(correlation) < 4 or correlation[0] <= 0:
        return 0
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation < 0)
    if not below.size:
        return 0
    peak = int(below[0] + np.argmax(correlation[below[0] :]))
    return peak if correlation[peak] > REPEATS else 0


def _smooth_down(rows: Array, length: float) -> Array:
    """Return rows correlated with their neighbours over ``length`` pixels, with unchanged variance."""
    reach = int(3 * length)
    window = np.exp(-0.5 * (np.arange(-reach, reach + 1) / length) ** 2)
    spectrum = np.fft.rfft(rows, axis=0)
    padded = np.zeros(len(rows))
    padded[np.arange(-reach, reach + 1) % len(rows)] = window / np.sqrt(np.sum(window**2))
    smooth: Array = np.fft.irfft(spectrum * np.fft.rfft(padded)[:, None], n=len(rows), axis=0)
    return smooth


def _lit(height: Array) -> NDArray[np.uint8]:
    """Return the pixels of a relief, brighter on slopes that face the light."""
    slope = np.gradient(height, axis=1)
    size = float(np.quantile(np.abs(slope), 0.98)) or 1.0
    bright = 1 + 0.28 * np.clip(slope / size, -1, 1) + 0.08 * np.clip(height / 2, -1, 1)
    pixels: NDArray[np.uint8] = np.clip(bright[:, :, None] * LIGHT, 0, 255).astype(np.uint8)
    return pixels


def _webp(pixels: NDArray[np.uint8]) -> bytes:
    with io.BytesIO() as buffer:
        Pillow.fromarray(np.ascontiguousarray(pixels)).save(buffer, format="webp", quality=QUALITY)
        return buffer.getvalue()
