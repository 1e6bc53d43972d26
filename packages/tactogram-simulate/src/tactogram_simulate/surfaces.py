"""Surfaces as height fields: sums of gratings, weaves, bumps, particles and power-law roughness.

A field is a periodic patch of `PATCH_MM`, about as large as the plates of Saga et al. ("about 100 mm in length and
width"); a longer stroke repeats it. Heights are in mm over a square grid of `MM_PER_PIXEL`.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.fft import fft, fftfreq, ifft, irfft, irfft2, rfft, rfft2, rfftfreq
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial import cKDTree
from scipy.special import j1

SIZE = 2048
MM_PER_PIXEL = 0.05
PATCH_MM = SIZE * MM_PER_PIXEL


@dataclass(frozen=True)
class Grating:
    """Ridges: a cosine of ``period_mm`` and ``height_mm`` (peak to valley), steeper for ``sharpness`` > 1.

    ``angle_deg`` is the direction across the ridges; they meander by ``wander_mm``.
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

    ``order`` 0 places them at random, 1 on a grid, values between jitter the grid. They are Gaussian, or with
    ``edge_mm`` > 0 flat discs with a rim of that width: punched holes, pores.
    """

    density: float
    radius_mm: float
    height_mm: float
    order: float = 0.0
    edge_mm: float = 0.0


@dataclass(frozen=True)
class Roughness:
    """Isotropic roughness of ``rms_mm`` with spectrum k^-beta between ``low`` and ``high`` cycles per mm.

    Self-affine surfaces: Persson et al. 2005, J. Phys. Condens. Matter 17:R1. It is longer than wide along y by
    ``stretch``: the grain of wood.
    """

    rms_mm: float
    beta: float = 2.0
    low: float = 0.1
    high: float = 5.0
    stretch: float = 1.0


@dataclass(frozen=True)
class Cells:
    """Granules pressed together, ``size_mm`` apart: domes of ``height_mm`` that meet in seams (Worley 1996).

    Their levels differ by ``uneven_mm`` rms: cork, foam beads.
    """

    size_mm: float
    height_mm: float
    uneven_mm: float = 0.0


Texture = Grating | Weave | Particles | Roughness | Cells
Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Appearance:
    """Appearance of a surface besides its heights."""

    colour: Colour = (0.35, 0.35, 0.35)  # albedo of the tops, linear light, 0..1
    hollow: Colour | None = None  # albedo of the hollows, by default that of the tops
    mottle: float = 0.05  # relative rms variation of the albedo
    grain_mm: float = 4.0  # size of the largest spots
    streak: float = 1.0  # their length over their width, along y
    gloss: float = 0.0  # strength of the reflection of the lamp


@dataclass(frozen=True)
class Surface:
    """A material: its height field, mechanics and look."""

    name: str
    textures: tuple[Texture, ...]  # added up
    friction: float  # Coulomb coefficient mu_c while sliding
    stiction: float = 1.15  # static coefficient over mu_c, >= 1
    stribeck_mm_s: float = 10.0  # velocity of the Stribeck curve
    stiffness_n_m: float = 1e5  # under the contactor: foam 200, tile 1e6
    loss: float = 0.0  # loss factor of the contact: it adds loss sqrt(k m) to its damping
    look: Appearance = Appearance()
    felt: float = 1.0  # share of its heights that is felt, where its level was measured
    ground: Roughness | None = None  # that is felt besides, and not seen


@lru_cache(maxsize=4)
def height_field(surface: Surface) -> NDArray[np.float32]:
    """Return the heights of a surface, mm, float32, shape (row, column), mean 0; they depend on the surface alone."""
    rng = np.random.default_rng(zlib.crc32(surface.name.encode()))
    heights = np.zeros((SIZE, SIZE))
    for texture in surface.textures:
        heights += _heights(texture, rng)
    heights -= heights.mean()
    result = heights.astype(np.float32)
    result.flags.writeable = False
    return result


def felt_heights(surface: Surface) -> NDArray[np.floating]:
    """Return the heights that are felt, mm: those seen, or a share of them and the ground."""
    heights = height_field(surface)
    if surface.ground is None:
        return heights  # as float32: the stores of benchmark tasks keep their hashes
    ground = _heights(surface.ground, np.random.default_rng(zlib.crc32(f"{surface.name} ground".encode())))
    return surface.felt * heights.astype(np.float64) + ground


def power_law(
    rng: np.random.Generator, beta: float, low: float, high: float, stretch: float = 1.0
) -> NDArray[np.float64]:
    """Return a periodic random field of rms 1, float64, shape (row, column).

    Along a line its power falls as k^-beta between ``low`` and ``high`` cycles per mm (over the plane as k^-(beta +
    1)); it is longer than wide along y by ``stretch``.
    """
    ky, kx = frequencies()
    columns = np.count_nonzero(kx <= high)  # the rest of the spectrum is 0, and so is its transform over rows
    radius = np.hypot(ky * stretch, kx[:, :columns])
    inside = (radius >= low) & (radius <= high)
    amplitude = np.zeros_like(radius)
    amplitude[inside] = radius[inside] ** (-(beta + 1) / 2)
    spectrum = fft(rfft(rng.standard_normal((SIZE, SIZE)))[:, :columns], axis=0)
    spectrum *= amplitude
    field = np.asarray(irfft(ifft(spectrum, axis=0, overwrite_x=True), SIZE))
    field /= field.std()
    return field


def frequencies() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the spatial frequencies of `rfft2` of a field, cycles per mm: a column of ky and a row of kx >= 0."""
    return fftfreq(SIZE, MM_PER_PIXEL)[:, None], rfftfreq(SIZE, MM_PER_PIXEL)[None, :]


def inverse(spectrum: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the field whose `rfft2` is ``spectrum``, float64, shape (row, column)."""
    return np.asarray(irfft2(spectrum, s=(SIZE, SIZE)))


def _heights(texture: Texture, rng: np.random.Generator) -> NDArray[np.float64]:
    match texture:
        case Grating():
            return _grating(texture, rng)
        case Weave():
            return _weave(texture)
        case Particles():
            return _particles(texture, rng)
        case Cells():
            return _cells(texture, rng)
        case Roughness():
            rough = power_law(rng, texture.beta, texture.low, texture.high, texture.stretch)
            return texture.rms_mm * rough


def _axes() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return y as a column and x as a row, mm."""
    line: NDArray[np.float64] = MM_PER_PIXEL * np.arange(SIZE, dtype=np.float64)
    return line[:, None], line[None, :]


def _grating(texture: Grating, rng: np.random.Generator) -> NDArray[np.float64]:
    y, x = _axes()
    angle = np.deg2rad(texture.angle_deg)
    # Whole periods on the patch, so that it stays periodic.
    across = round(PATCH_MM / texture.period_mm * np.cos(angle))
    along = round(PATCH_MM / texture.period_mm * np.sin(angle))
    turns = (across * x + along * y) / PATCH_MM
    if texture.wander_mm:
        turns = turns + texture.wander_mm / texture.period_mm * power_law(rng, 2.5, 0.02, 0.5)
    return np.asarray(texture.height_mm * (0.5 + 0.5 * np.cos(2 * np.pi * turns)) ** texture.sharpness)


def _weave(texture: Weave) -> NDArray[np.float64]:
    """Return a plain weave: round yarns that go over and under each other."""
    y, x = _axes()
    count = 2 * max(1, round(PATCH_MM / texture.period_mm / 2))
    warp, weft = np.pi * count * x / PATCH_MM, np.pi * count * y / PATCH_MM
    turn = np.sin(warp + np.pi / 2) * np.sin(weft + np.pi / 2)
    yarn_x = np.sqrt(np.abs(np.sin(warp))) * (0.6 + 0.4 * turn)
    yarn_y = np.sqrt(np.abs(np.sin(weft))) * (0.6 - 0.4 * turn)
    woven = gaussian_filter(np.maximum(yarn_x, yarn_y), 1, mode="wrap")
    return np.asarray(texture.height_mm * (woven - woven.min()) / np.ptp(woven))


def _particles(texture: Particles, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return the sum of bumps, a convolution over the periodic patch; flat ones do not pile up."""
    side = max(1, round(np.sqrt(texture.density) * PATCH_MM))
    grid = np.stack(np.meshgrid(*[(np.arange(side) + 0.5) / side] * 2, indexing="ij"), -1).reshape(-1, 2)
    random = rng.random((side * side, 2))
    order = min(max(texture.order, 0.0), 1.0)
    places = grid + (1 - order) * (random - 0.5) / side if order > 0 else random
    pixels = np.floor(places % 1 * SIZE).astype(int)
    impulses = np.zeros((SIZE, SIZE))
    size = 1 + (1 - order) * 0.3 * rng.standard_normal(len(pixels))
    np.add.at(impulses, (pixels[:, 0], pixels[:, 1]), 1.0 if texture.edge_mm else size)
    ky, kx = frequencies()
    k = np.hypot(ky, kx)
    if texture.edge_mm:
        q = 2 * np.pi * k * texture.radius_mm
        q[0, 0] = 1e-9
        disc = 2 * j1(q) / q * np.exp(-2 * (np.pi * texture.edge_mm * k) ** 2)
        bumps = inverse(rfft2(impulses) * disc) * np.pi * (texture.radius_mm / MM_PER_PIXEL) ** 2
        return texture.height_mm * np.clip(bumps, 0, 1)
    sigma = texture.radius_mm / 2
    bumps = inverse(rfft2(impulses) * np.exp(-2 * (np.pi * sigma * k) ** 2))
    return texture.height_mm * bumps * 2 * np.pi * (sigma / MM_PER_PIXEL) ** 2


def _cells(texture: Cells, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return domes over the nearest of random points, looked up on half the grid, which is ten times as fast."""
    half = SIZE // 2
    side = max(2, round(PATCH_MM / texture.size_mm))
    grid = np.stack(np.meshgrid(*[np.arange(side) + 0.5] * 2, indexing="ij"), -1).reshape(-1, 2)
    points = (grid + 0.9 * (rng.random(grid.shape) - 0.5)) * PATCH_MM / side % PATCH_MM
    line = (np.arange(half) * 2) * MM_PER_PIXEL
    places = np.stack(np.meshgrid(line, line, indexing="ij"), -1).reshape(-1, 2)
    distance, nearest = cKDTree(points, boxsize=PATCH_MM).query(places, k=2)
    seam = np.clip((distance[:, 1] - distance[:, 0]) / texture.size_mm, 0, 1)
    level = texture.uneven_mm * rng.standard_normal(len(points))[nearest[:, 0]]
    domes = texture.height_mm * np.sqrt(1 - (1 - np.minimum(1, 1.5 * seam)) ** 2) + level
    coarse = gaussian_filter(domes.reshape(half, half), 0.7, mode="wrap")
    at = np.arange(SIZE) / 2
    return np.asarray(map_coordinates(coarse, np.meshgrid(at, at, indexing="ij"), order=1, mode="grid-wrap"))
