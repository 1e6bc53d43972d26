"""Simulated photograph of a surface, rendered from the height field that is touched."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from tactogram.errors import ParameterError
from tactogram.signal import Image
from tactogram_simulate.surfaces import MM_PER_PIXEL, Surface, height_field, power_law

PIXELS = 256
POOL = 3
"""Cells of the height field per pixel in each direction."""
MOST, SIDE = 9, 672
"""Most photographs of one patch without overlap, and pixels of the patch in each direction."""
AZIMUTH_DEG, ELEVATION_DEG = 225.0, 40.0
"""Position of the lamp: upper left, low enough for relief to show."""
AMBIENT = 0.3
SHININESS = 40.0


@lru_cache(maxsize=32)
def photograph(surface: Surface) -> Image:
    """Return the surface under a lamp at the upper left, seen from above.

    Lambert's law over the slopes, a highlight (Blinn 1977) for gloss, less light in the hollows (height below the
    neighbourhood, a cheap ambient occlusion), and an albedo that varies with height and over the surface. Linear light
    until the end, then sRGB (IEC 61966-2-1). 256 x 256 pixels of 0.15 mm: the first 38.4 mm of the height field, x to
    the right and y downwards.
    """
    return render(surface, rows=PIXELS, columns=PIXELS, pool=POOL)


def photographs(surface: Surface, count: int) -> Iterator[Image]:
    """Yield photographs of ``count`` places (0 to 9) of the surface that do not overlap.

    Pixels of 0.15 mm, 224 x 224 of them, or 336 x 336 for ``count`` up to 4, 672 x 672 for 1. The photograph of
    `photograph` overlaps some of them: use one or the other.
    """
    if not 0 <= count <= MOST:
        raise ParameterError(f"a simulated surface has room for 0 to {MOST} photographs, got {count}")
    if count == 0:
        return
    across = math.isqrt(count - 1) + 1
    side = SIDE // across
    whole = render(surface, rows=SIDE, columns=SIDE, pool=POOL)
    for number in range(count):
        top, left = (side * n for n in divmod(number, across))
        yield whole.cut(top, left, top + side, left + side)


def render(surface: Surface, *, rows: int, columns: int, pool: int) -> Image:
    """Return the first ``rows`` x ``columns`` pixels of a surface, each the mean of ``pool`` x ``pool`` cells."""
    heights = height_field(surface)[: rows * pool, : columns * pool].astype(np.float64)
    dy, dx = np.gradient(heights, MM_PER_PIXEL)
    normal = np.stack([-dx, -dy, np.ones_like(dx)])
    normal /= np.sqrt((normal**2).sum(0))
    lamp = _direction(AZIMUTH_DEG, ELEVATION_DEG)
    halfway = lamp + np.array([0.0, 0.0, 1.0])
    halfway /= np.linalg.norm(halfway)
    lambert = np.clip(np.einsum("i,iyx->yx", lamp, normal), 0, None) / lamp[2]
    shine = np.clip(np.einsum("i,iyx->yx", halfway, normal) / halfway[2], 0, None) ** SHININESS

    below = np.clip(gaussian_filter(heights, 0.5 / MM_PER_PIXEL) - heights, 0, None)
    open_sky = 1 / (1 + 2.5 * below)
    light = open_sky * (AMBIENT + (1 - AMBIENT) * lambert)
    linear = _albedo(surface, heights) * light[..., None]
    linear += surface.look.gloss * (open_sky * shine)[..., None]
    pooled = linear.reshape(rows, pool, columns, pool, 3).mean((1, 3))
    return Image(_srgb(pooled), mm_per_pixel=pool * MM_PER_PIXEL)


def _albedo(surface: Surface, heights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the albedo, linear RGB, shape (row, column, 3)."""
    look = surface.look
    low, high = np.percentile(heights, (2, 98))
    height = np.clip((heights - low) / max(high - low, 1e-9), 0, 1)[..., None]
    top, hollow = np.array(look.colour), np.array(look.hollow or look.colour)
    rng = np.random.default_rng(zlib.crc32(f"{surface.name} photograph".encode()))
    spots = power_law(rng, 0.6, 1 / look.grain_mm, 6.0, look.streak)[: heights.shape[0], : heights.shape[1]]
    shade = np.exp(look.mottle * np.clip(spots, -3, 3))
    return np.asarray((hollow + (top - hollow) * height) * shade[..., None])


def _direction(azimuth_deg: float, elevation_deg: float) -> NDArray[np.float64]:
    """Return the unit vector towards the lamp: azimuth from x towards y (right, then down), elevation up."""
    a, e = np.deg2rad(azimuth_deg), np.deg2rad(elevation_deg)
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def _srgb(linear: NDArray[np.float64]) -> NDArray[np.uint8]:
    x = np.clip(linear, 0, 1)
    coded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return np.round(255 * coded).astype(np.uint8)
