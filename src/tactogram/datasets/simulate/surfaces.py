"""Surfaces as height fields: sums of gratings, weaves, bumps, particles and power-law roughness.

A field is a periodic patch, so that a stroke of any length stays on it; a stroke crosses it at an angle and
does not meet the same line twice. Heights are in mm over a square grid of `MM_PER_PIXEL`.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

SIZE = 1024
MM_PER_PIXEL = 0.05
PATCH_MM = SIZE * MM_PER_PIXEL


@dataclass(frozen=True)
class Grating:
    """Ridges: a cosine of ``period_mm`` and ``height_mm`` (peak to valley), steeper for ``sharpness`` > 1.

    ``angle_deg`` is the direction across the ridges; ``wander_mm`` lets them meander.
    """

    period_mm: float
    height_mm: float
    angle_deg: float = 0.0
    sharpness: float = 1.0
    wander_mm: float = 0.0


@dataclass(frozen=True)
class Weave:
    """Warp and weft of ``period_mm``, ``height_mm`` peak to valley."""

    period_mm: float
    height_mm: float


@dataclass(frozen=True)
class Particles:
    """Round bumps (``height_mm`` > 0) or holes (< 0), ``density`` per mm^2, of ``radius_mm``.

    ``order`` 0 puts them at random, 1 on a grid, values between jitter the grid.
    """

    density: float
    radius_mm: float
    height_mm: float
    order: float = 0.0


@dataclass(frozen=True)
class Roughness:
    """Isotropic roughness of ``rms_mm`` with spectrum k^-beta between ``low`` and ``high`` cycles per mm.

    Self-affine surfaces: Persson et al. 2005, J. Phys. Condens. Matter 17:R1.
    """

    rms_mm: float
    beta: float = 2.0
    low: float = 0.1
    high: float = 5.0
    stretch: float = 1.0
    """Longer than wide along y by this factor: the grain of wood."""


Texture = Grating | Weave | Particles | Roughness


@dataclass(frozen=True)
class Surface:
    """A material: its height field, its mechanics, its look, and room for what people say of it.

    Parameters
    ----------
    name : str
    textures : tuple of Texture
        Added up.
    friction : float
        Coulomb coefficient mu_c while sliding.
    stiction : float
        Static coefficient over mu_c, >= 1.
    stribeck_mm_s : float
        Velocity of the Stribeck curve, mm/s.
    stiffness_n_m : float
        Of the surface under the contactor, N/m: foam 200, tile 1e6.
    damping : float
        Share of the vibration that the surface swallows, 0..1.
    colour : tuple of three floats in 0..1
        Albedo; ``mottle`` is how much it varies.
    words : mapping from str to float
        Perceptual descriptors; not used yet.
    """

    name: str
    textures: tuple[Texture, ...]
    friction: float
    stiction: float = 1.15
    stribeck_mm_s: float = 10.0
    stiffness_n_m: float = 1e5
    damping: float = 0.0
    colour: tuple[float, float, float] = (0.6, 0.6, 0.6)
    mottle: float = 0.05
    words: dict[str, float] = field(default_factory=dict, hash=False)


@cache
def height_field(surface: Surface) -> NDArray[np.float32]:
    """Return the heights of a surface, mm, float32, shape (row, column), mean 0; the same for the same surface."""
    rng = np.random.default_rng(zlib.crc32(surface.name.encode()))
    heights = np.zeros((SIZE, SIZE))
    for texture in surface.textures:
        heights += _heights(texture, rng)
    heights -= heights.mean()
    result = heights.astype(np.float32)
    result.flags.writeable = False
    return result


def _heights(texture: Texture, rng: np.random.Generator) -> NDArray[np.float64]:
    y, x = np.meshgrid(*[np.arange(SIZE) * MM_PER_PIXEL] * 2, indexing="ij")
    if isinstance(texture, Grating):
        angle = np.deg2rad(texture.angle_deg)
        # Whole periods on the patch, so that it stays periodic.
        across = round(PATCH_MM / texture.period_mm * np.cos(angle))
        along = round(PATCH_MM / texture.period_mm * np.sin(angle))
        wander = texture.wander_mm * _rough(rng, 2.5, 0.05, 0.5, 1.0) / texture.period_mm
        wave = 0.5 + 0.5 * np.cos(2 * np.pi * ((across * x + along * y) / PATCH_MM + wander))
        ridges: NDArray[np.float64] = texture.height_mm * wave**texture.sharpness
        return ridges
    if isinstance(texture, Weave):
        count = max(2, 2 * round(PATCH_MM / texture.period_mm / 2))
        warp, weft = np.pi * count * x / PATCH_MM, np.pi * count * y / PATCH_MM
        over = np.sign(np.sin(warp) * np.sin(weft))
        threads = np.where(over > 0, np.abs(np.sin(warp)), np.abs(np.sin(weft)))
        woven: NDArray[np.float64] = threads * (0.75 + 0.25 * np.abs(np.cos(warp) * np.cos(weft)))
        return texture.height_mm * woven
    if isinstance(texture, Particles):
        return _particles(texture, rng)
    return texture.rms_mm * _rough(rng, texture.beta, texture.low, texture.high, texture.stretch)


def _particles(texture: Particles, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the sum of Gaussian bumps, made by a convolution over the periodic patch."""
    count = max(1, round(texture.density * PATCH_MM**2))
    side = max(1, round(np.sqrt(count)))
    grid = np.stack(np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2, indexing="ij"), -1).reshape(-1, 2)
    random = rng.random((side * side, 2))
    if texture.order >= 1:
        places = grid
    elif texture.order <= 0:
        places = random
    else:
        places = grid + (1 - texture.order) * (random - 0.5) / side
    pixels = np.floor(places % 1 * SIZE).astype(int)
    impulses = np.zeros((SIZE, SIZE))
    size = 1 + (1 - texture.order) * 0.3 * rng.standard_normal(len(pixels))
    np.add.at(impulses, (pixels[:, 0], pixels[:, 1]), size)
    k = np.fft.fftfreq(SIZE, MM_PER_PIXEL)
    sigma = texture.radius_mm / 2
    bump = np.exp(-2 * (np.pi * sigma) ** 2 * (k[:, None] ** 2 + k[None, : SIZE // 2 + 1] ** 2))
    bumps: NDArray[np.float64] = np.fft.irfft2(np.fft.rfft2(impulses) * bump, s=(SIZE, SIZE))
    peak = (MM_PER_PIXEL / sigma) ** 2 / (2 * np.pi)
    return texture.height_mm * bumps / peak


def _rough(
    rng: np.random.Generator, beta: float, low: float, high: float, stretch: float
) -> NDArray[np.float64]:
    """Return a periodic random field of rms 1 whose amplitude spectrum falls as k^(-beta/2)."""
    k = np.fft.fftfreq(SIZE, MM_PER_PIXEL)
    radius = np.hypot(k[:, None] * stretch, k[None, : SIZE // 2 + 1])
    inside = (radius >= low) & (radius <= high)
    amplitude = np.zeros_like(radius)
    amplitude[inside] = radius[inside] ** (-(beta + 1) / 2)
    spectrum = np.fft.rfft2(rng.standard_normal((SIZE, SIZE))) * amplitude
    heights: NDArray[np.float64] = np.fft.irfft2(spectrum, s=(SIZE, SIZE))
    heights /= heights.std()
    return heights
