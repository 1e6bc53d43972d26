"""Simulated pictures of imaginary materials that look tactile: sixteen families of formulas.

They replace the 320 images of the cross-modal study (Sec. II-B), which are not at hand. Each is a height field, an
albedo and a lamp; the simulated raters see the pixels alone, never the family or its parameters.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates
from scipy.spatial import cKDTree

from tactogram.signal import Image

PIXELS = 128
Array = NDArray[np.float64]
Rng = np.random.Generator

_Y, _X = np.meshgrid(*[np.arange(PIXELS) / PIXELS] * 2, indexing="ij")


def tactile_image(family: str, number: int, *, seed: int) -> Image:
    """Return picture ``number`` of a family of `FAMILIES`, 128 x 128 RGB; the same seed gives the same pixels."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(f"{family}/{number}".encode())]))
    rgb = FAMILIES[family](rng)
    return Image(np.round(255 * np.clip(rgb, 0, 1) ** (1 / 2.2)).astype(np.uint8))


def _noise(
    rng: Rng, slope: float, low: float, high: float, *, stretch: float = 1.0, turn: float = 0.0
) -> Array:
    """Return a random field of rms 1 between ``low`` and ``high`` cycles per side, amplitudes as k^-slope.

    It is longer than wide by ``stretch``, along ``turn`` (radians).
    """
    ky, kx = np.fft.fftfreq(PIXELS, 1 / PIXELS)[:, None], np.fft.rfftfreq(PIXELS, 1 / PIXELS)[None]
    along, across = kx * np.cos(turn) + ky * np.sin(turn), ky * np.cos(turn) - kx * np.sin(turn)
    k = np.hypot(along * stretch, across)
    gain = np.where((k >= low) & (k <= high), np.maximum(k, 0.5) ** -slope, 0.0)
    x = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((PIXELS, PIXELS))) * gain, s=(PIXELS, PIXELS))
    return np.asarray(x / max(float(x.std()), 1e-9))


def _lit(
    rng: Rng, height: Array, colour: Array, *, relief: float, gloss: float = 0.0, shine: float = 30.0
) -> Array:
    """Return a height field under a lamp at the upper left: Lambert, a Blinn highlight, darker hollows."""
    dy, dx = np.gradient(relief * height * PIXELS / 10)
    normal = np.stack([-dx, -dy, np.ones_like(dx)]) / np.sqrt(dx**2 + dy**2 + 1)
    azimuth, elevation = np.deg2rad(225 + 25 * rng.standard_normal()), np.deg2rad(rng.uniform(38, 60))
    lamp = np.array(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )
    half = (lamp + np.array([0.0, 0.0, 1.0])) / np.linalg.norm(lamp + np.array([0.0, 0.0, 1.0]))
    lambert = np.clip(np.einsum("i,iyx->yx", lamp, normal), 0, None) / lamp[2]
    mirror = np.clip(np.einsum("i,iyx->yx", half, normal), 0, 1) ** shine
    hollow = 1 / (1 + 2 * relief * np.clip(gaussian_filter(height, 6) - height, 0, None))
    light = (0.25 + 0.75 * lambert) * hollow
    return np.asarray(colour * light[..., None] + gloss * mirror[..., None])


def _hue(rng: Rng, low: tuple[float, float, float], high: tuple[float, float, float]) -> Array:
    """Return a colour between two, shape (1, 1, 3), the same share of the way in all channels plus noise."""
    way = np.clip(rng.random() + 0.1 * rng.standard_normal(3), 0, 1)
    return np.asarray(np.array(low) + (np.array(high) - np.array(low)) * way)[None, None]


def _points(rng: Rng, across: float, order: float) -> Array:
    """Return points (y, x) in 0..1, about ``across`` each way: on a grid for order 1, at random for 0."""
    side = max(2, round(across))
    grid = np.stack(np.meshgrid(*[np.arange(-1, side + 1) + 0.5] * 2, indexing="ij"), -1).reshape(-1, 2)
    return np.asarray((grid + (1 - order) * (rng.random(grid.shape) - 0.5)) / side)


def _nearest(points: Array) -> tuple[Array, Array, NDArray[np.intp]]:
    """Return distances to the nearest and next point, and the index of the nearest, shape (row, column) each."""
    distance, which = cKDTree(points).query(np.stack([_Y, _X], -1).reshape(-1, 2), k=2)
    shape = (PIXELS, PIXELS)
    return distance[:, 0].reshape(shape), distance[:, 1].reshape(shape), which[:, 0].reshape(shape)


def _polished(rng: Rng) -> Array:
    sky = gaussian_filter(_noise(rng, 2.0, 0.5, 3, stretch=rng.uniform(1, 4), turn=rng.uniform(0, 3)), 3)
    base = _hue(rng, (0.30, 0.31, 0.33), (0.55, 0.54, 0.52)) * (1 + 0.35 * sky[..., None])
    streak = rng.uniform(0.2, 0.7) * np.exp(-(((_X + _Y - rng.uniform(0.5, 1.5)) / 0.12) ** 2))
    return np.asarray(base + streak[..., None])


def _brushed(rng: Rng) -> Array:
    turn, depth = rng.uniform(0, 3), rng.uniform(0.06, 0.3)
    lines = _noise(rng, 0.3, 3, 60, stretch=rng.uniform(15, 40), turn=turn)
    base = _hue(rng, (0.25, 0.25, 0.27), (0.55, 0.48, 0.36)) * (1 + 0.12 * _noise(rng, 2, 0.5, 2)[..., None])
    return base * (1 + depth * lines[..., None])


def _sand(rng: Rng) -> Array:
    grain = _noise(rng, rng.uniform(-0.3, 0.5), 6, rng.uniform(30, 60))
    ripple = rng.choice([0.0, 0.6]) * _noise(rng, 2.0, 1, 5, stretch=3, turn=rng.uniform(0, 3))
    colour = _hue(rng, (0.55, 0.42, 0.27), (0.62, 0.60, 0.56)) * (
        1 + 0.15 * rng.standard_normal((PIXELS, PIXELS, 1))
    )
    return _lit(rng, 0.02 * grain + 0.1 * ripple, colour, relief=rng.uniform(0.6, 2.0))


def _stones(rng: Rng) -> Array:
    near, far, which = _nearest(_points(rng, rng.uniform(3, 8), 0.2))
    seam = np.clip((far - near) / rng.uniform(0.06, 0.15), 0, 1)
    dome = np.sqrt(1 - (1 - np.minimum(seam, 1)) ** 2) + 0.1 * _noise(rng, 1.0, 4, 40)
    shade = 1 + 0.3 * rng.standard_normal(which.max() + 1)[which][..., None]
    colour = _hue(rng, (0.22, 0.21, 0.20), (0.42, 0.36, 0.30)) * np.clip(shade, 0.3, 2)
    return _lit(
        rng,
        0.3 * gaussian_filter(dome, 1),
        0.8 * colour,
        relief=rng.uniform(1.2, 2.4),
        gloss=rng.choice([0, 0, 0.15]),
    )


def _bumps(rng: Rng) -> Array:
    across, order = rng.uniform(4, 12), rng.choice([1.0, 0.9, 0.4])
    near, _, _ = _nearest(_points(rng, across, order))
    radius = rng.uniform(0.28, 0.48) / across
    dome = np.sqrt(np.clip(1 - (near / radius) ** 2, 0, None)) * radius * 8
    colour = _hue(rng, (0.15, 0.25, 0.45), (0.55, 0.50, 0.48))
    return _lit(
        rng,
        0.25 * gaussian_filter(dome, 0.8),
        colour,
        relief=rng.uniform(0.6, 1.5),
        gloss=rng.uniform(0, 0.5),
    )


def _holes(rng: Rng) -> Array:
    across = rng.uniform(4, 11)
    near, _, _ = _nearest(_points(rng, across, rng.choice([1.0, 1.0, 0.5])))
    open_ = 1 / (1 + np.exp((near - rng.uniform(0.25, 0.4) / across) * 250))
    sheet = _hue(rng, (0.35, 0.35, 0.37), (0.60, 0.58, 0.55)) * (
        1 + 0.1 * _noise(rng, 1.5, 0.5, 4)[..., None]
    )
    return _lit(rng, -0.06 * gaussian_filter(open_, 0.8), sheet, relief=1.0, gloss=0.1) * (
        1 - 0.5 * open_[..., None]
    )


def _fur(rng: Rng) -> Array:
    turn, length = rng.uniform(0, 3), rng.uniform(6, 14)
    hair = _noise(rng, 0.2, 4, rng.uniform(25, 60), stretch=length, turn=turn)
    bend = 6 * _noise(rng, 2.5, 0.5, 3)
    points = np.stack([_Y * PIXELS + bend, _X * PIXELS - bend])
    hair = map_coordinates(hair, points, order=1, mode="wrap")
    colour = _hue(rng, (0.20, 0.13, 0.07), (0.72, 0.66, 0.58)) * (1 + 0.25 * _noise(rng, 2, 1, 4)[..., None])
    return _lit(rng, 0.05 * hair, np.clip(colour, 0.02, 1), relief=rng.uniform(0.5, 1.2))


def _gel(rng: Rng) -> Array:
    height = gaussian_filter(_noise(rng, 2.2, 1, rng.uniform(4, 7)), 2)
    colour = _hue(
        rng,
        *[tuple(c) for c in rng.permuted([(0.75, 0.15, 0.25), (0.20, 0.65, 0.35), (0.25, 0.35, 0.80)])[:2]],
    )
    glow = 1 + 0.25 * height[..., None]
    return _lit(
        rng,
        0.4 * height,
        0.7 * colour * glow,
        relief=rng.uniform(0.5, 1.2),
        gloss=rng.uniform(0.4, 1.0),
        shine=rng.uniform(60, 200),
    )


def _spikes(rng: Rng) -> Array:
    points = _points(rng, rng.uniform(6, 13), rng.choice([0.3, 0.9]))
    dark = _hue(rng, (0.05, 0.10, 0.05), (0.25, 0.22, 0.18)) * (1 + 0.2 * _noise(rng, 1.0, 2, 20)[..., None])
    lean, length, width = rng.uniform(0, 6.3), rng.uniform(0.05, 0.13), rng.uniform(0.003, 0.007)
    light = np.zeros((PIXELS, PIXELS))
    for y, x in points:
        angle = lean + rng.normal(0, 0.5)
        along = (_X - x) * np.cos(angle) + (_Y - y) * np.sin(angle)
        across = (_Y - y) * np.cos(angle) - (_X - x) * np.sin(angle)
        thin = width * np.clip(1 - along / length, 0.1, 1)
        spike = np.exp(-((across / thin) ** 2)) * ((along > 0) & (along < length))
        light = np.maximum(light, spike)
    tip = _hue(rng, (0.70, 0.65, 0.45), (0.95, 0.93, 0.90))
    return dark + (tip - dark) * light[..., None]


def _wet(rng: Rng) -> Array:
    across = rng.uniform(3, 9)
    near, _, which = _nearest(_points(rng, across, 0.1))
    radius = (rng.uniform(0.15, 0.45, which.max() + 1) / across)[which]
    drop = np.sqrt(np.clip(1 - (near / radius) ** 2, 0, None)) * radius * 6
    film = gaussian_filter(_noise(rng, 2.0, 1, 5), 2)
    colour = _hue(rng, (0.45, 0.22, 0.03), (0.35, 0.05, 0.06)) * (1 + 0.2 * film[..., None])
    return _lit(
        rng,
        0.12 * gaussian_filter(drop, 1) + 0.03 * film,
        colour,
        relief=1.2,
        gloss=rng.uniform(0.5, 1.0),
        shine=rng.uniform(30, 90),
    )


def _crumpled(rng: Rng) -> Array:
    height = np.zeros((PIXELS, PIXELS))
    for scale in (rng.uniform(2, 4), rng.uniform(5, 9)):
        points = _points(rng, scale, 0.0)
        near, far, which = _nearest(points)
        away = np.stack([_Y, _X], -1) - points[which]
        tilt = rng.standard_normal((len(points), 2))[which]
        height += (tilt * away).sum(-1) + 0.3 * (far - near)
    colour = _hue(rng, (0.60, 0.58, 0.52), (0.78, 0.78, 0.80))
    return _lit(
        rng,
        4.0 * gaussian_filter(height, 0.8),
        0.8 * colour,
        relief=rng.uniform(0.6, 1.2),
        gloss=rng.choice([0, 0, 0.4]),
    )


def _leaves(rng: Rng) -> Array:
    near, far, which = _nearest(_points(rng, rng.uniform(3, 6), 0.0))
    angle = rng.uniform(0, 6.3, which.max() + 1)[which]
    vein = np.cos(40 * (np.cos(angle) * _X + np.sin(angle) * _Y) * 2)
    edge = np.clip((far - near) * 12, 0, 1)
    tone = rng.random(which.max() + 1)[which][..., None]
    colour = (1 - tone) * np.array([0.42, 0.20, 0.05]) + tone * _hue(
        rng, (0.60, 0.42, 0.14), (0.25, 0.30, 0.08)
    )
    height = 0.5 * edge + 0.06 * np.abs(vein) + 0.12 * _noise(rng, 1.2, 4, 30)
    return _lit(rng, 0.12 * height, colour * (0.35 + 0.65 * edge[..., None]), relief=rng.uniform(0.8, 1.6))


def _wood(rng: Rng) -> Array:
    turn = rng.choice([0.0, np.pi / 2]) + 0.1 * rng.standard_normal()
    across = _Y * np.cos(turn) - _X * np.sin(turn) + 0.03 * _noise(rng, 2.2, 0.5, 3, stretch=4, turn=turn)
    rings = 0.5 + 0.5 * np.sin(2 * np.pi * rng.uniform(5, 14) * across)
    pores = _noise(rng, 0.3, 6, 60, stretch=12, turn=turn)
    light, dark = _hue(rng, (0.62, 0.42, 0.22), (0.70, 0.55, 0.38)), np.array([0.28, 0.15, 0.06])
    colour = light + (dark - light) * (0.6 * rings**2)[..., None]
    return _lit(rng, 0.015 * pores, colour, relief=rng.uniform(0.3, 1.5), gloss=rng.choice([0, 0.15]))


def _fabric(rng: Rng) -> Array:
    count = rng.integers(8, 26)
    warp, weft = np.pi * count * _X, np.pi * count * _Y
    turn = np.sign(np.sin(warp) * np.sin(weft))
    over = np.where(turn > 0, np.sqrt(np.abs(np.sin(warp))), np.sqrt(np.abs(np.sin(weft))))
    one, other = (
        _hue(rng, (0.15, 0.20, 0.42), (0.62, 0.56, 0.48)),
        _hue(rng, (0.45, 0.12, 0.14), (0.68, 0.66, 0.62)),
    )
    colour = np.where(turn[..., None] > 0, one, one + rng.choice([0.15, 0.8]) * (other - one))
    return _lit(
        rng,
        0.02 * gaussian_filter(over, 0.7) + 0.003 * _noise(rng, 0, 20, 60),
        colour,
        relief=rng.uniform(0.8, 2.0),
    )


def _bark(rng: Rng) -> Array:
    turn = rng.choice([0.0, np.pi / 2]) + 0.2 * rng.standard_normal()
    cracks = 1 - np.abs(_noise(rng, 1.1, 1.5, 30, stretch=rng.uniform(1, 4), turn=turn))
    height = np.minimum(0, 0.75 - np.clip(cracks, 0, 1)) + 0.12 * _noise(rng, 0.8, 4, 50)
    colour = _hue(rng, (0.18, 0.12, 0.08), (0.40, 0.33, 0.27)) * (
        1 + 0.2 * _noise(rng, 1.5, 1, 10)[..., None]
    )
    return _lit(rng, 0.8 * height, np.clip(colour, 0.02, 1), relief=rng.uniform(0.8, 1.6))


def _glazed(rng: Rng) -> Array:
    bow = rng.uniform(0.3, 1.2) * ((_X - rng.random()) ** 2 + (_Y - rng.random()) ** 2)
    colour = _hue(rng, (0.12, 0.30, 0.50), (0.85, 0.82, 0.78)) * (1.15 - 0.5 * bow[..., None])
    y, x = rng.uniform(0.2, 0.8, 2)
    lamp = np.exp(
        -((((_X - x) / rng.uniform(0.05, 0.15)) ** 2 + ((_Y - y) / rng.uniform(0.05, 0.2)) ** 2) ** 2)
    )
    return np.asarray(colour + rng.uniform(0.3, 1.0) * lamp[..., None])


FAMILIES: dict[str, Callable[[Rng], Array]] = {
    "polished": _polished, "brushed": _brushed, "sand": _sand, "stones": _stones,
    "bumps": _bumps, "holes": _holes, "fur": _fur, "gel": _gel,
    "spikes": _spikes, "wet": _wet, "crumpled": _crumpled, "leaves": _leaves,
    "wood": _wood, "fabric": _fabric, "bark": _bark, "glazed": _glazed,
}  # fmt: skip
