"""A photograph of a surface, rendered from the same height field that is felt."""

from __future__ import annotations

import zlib
from functools import cache

import numpy as np

from tactogram.datasets.simulate.surfaces import MM_PER_PIXEL, SIZE, Surface, height_field
from tactogram.signal import Image

PIXELS = 256
LIGHT = np.array([-0.55, -0.55, 0.63])
AMBIENT = 0.35


@cache
def photograph(surface: Surface) -> Image:
    """Return the surface lit from the upper left: Lambert's law over the slopes, hollows darkened, colour mottled.

    Returns
    -------
    Image
        256 x 256 pixels of 0.1 mm.
    """
    heights = height_field(surface).astype(np.float64)
    crop = heights[: 2 * PIXELS, : 2 * PIXELS]
    dy, dx = np.gradient(crop, MM_PER_PIXEL)
    normal = np.stack([-dx, -dy, np.ones_like(crop)])
    normal /= np.linalg.norm(normal, axis=0)
    lambert = np.clip(np.tensordot(LIGHT / np.linalg.norm(LIGHT), normal, 1), 0, None)
    spread = np.ptp(crop) or 1.0
    hollow = 0.75 + 0.25 * (crop - crop.min()) / spread
    rng = np.random.default_rng(zlib.crc32(surface.name.encode()) + 1)
    mottle = _smooth_noise(rng)[: 2 * PIXELS, : 2 * PIXELS]
    shade = (AMBIENT + (1 - AMBIENT) * lambert / 0.63) * hollow * (1 + surface.mottle * mottle)
    colour = np.array(surface.colour)[None, None] * shade[..., None]
    half = colour.reshape(PIXELS, 2, PIXELS, 2, 3).mean((1, 3))
    pixels = np.round(255 * np.clip(half, 0, 1) ** (1 / 1.6)).astype(np.uint8)
    return Image(pixels, mm_per_pixel=2 * MM_PER_PIXEL)


def _smooth_noise(rng: np.random.Generator) -> np.ndarray:
    k = np.fft.fftfreq(SIZE)
    low = 1 / (0.01 + np.hypot(k[:, None], k[None, : SIZE // 2 + 1]))
    field = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((SIZE, SIZE))) * low, s=(SIZE, SIZE))
    return np.asarray(field / field.std())
