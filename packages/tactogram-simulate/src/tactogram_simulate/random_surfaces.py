"""Surfaces, and fingers and styluses that stroke them, drawn at random: to train on, not models of materials.

Sizes, heights and mechanics are log-uniform; colours say nothing of the heights, but hollows, light and spots show
them. By a stylus the population has the level and spread, the centroid and slope of the spectrum, and the powers of
speed and force with which they grow, of the 100 materials of the Penn Haptic Texture Toolkit (Culbertson et al. 2014),
as aggregates: ``python -m benchmarks real_surfaces`` compares them. Self-affine roughness has them by itself: where
heights fall as k^-beta, a speed multiplies all of the spectrum by v^(beta - 1) (beta from 2 to 3: Persson et al. 2005,
J. Phys. Condens. Matter 17:R1).
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from tactogram_simulate.contact import Contactor
from tactogram_simulate.surfaces import (
    Appearance,
    Cells,
    Grating,
    Particles,
    Roughness,
    Surface,
    Texture,
    Weave,
)

SPEEDS_MM_S = (30.0, 400.0)
"""Range of stroking speeds."""
FORCES_N = (0.2, 3.0)
"""Range of mean normal forces."""
TEXTURES = (0.75, 0.2, 0.05)
"""Shares of the surfaces with none, one and two textures beside their fine roughness."""
BODIES = 0.35
"""Standard deviation of the logarithms of a contactor's size, mass (sensor included), stiffness and damping."""
VARIED = (
    "radius_mm", "ridges_mm", "mass_kg", "stiffness_n_m", "damping_n_s_m", "grip_mass_kg", "grip_n_m", "grip_n_s_m"
)  # fmt: skip


@lru_cache(maxsize=64)
def random_surface(seed: int, number: int) -> Surface:
    """Return surface ``number`` of those that ``seed`` draws: up to two textures and fine roughness."""
    rng = np.random.default_rng([seed, number, 0])
    drawn = [
        _TEXTURES[rng.integers(len(_TEXTURES))](rng) for _ in range(rng.choice(len(TEXTURES), p=TEXTURES))
    ]
    hard = rng.random() < 0.4
    return Surface(
        f"random-{seed}-{number:05d}",
        (*drawn, _roughness(rng)),
        rng.uniform(0.25, 1.0),
        rng.uniform(1.05, 1.35),
        rng.uniform(5, 20),
        stiffness_n_m=1e5 if hard else _between(rng, 500, 5e4),
        loss=0.0 if hard else rng.uniform(0, 0.9),
        look=_appearance(rng),
    )


def random_contactor(seed: int, number: int, usual: Contactor) -> Contactor:
    """Return the contactor that strokes surface ``number``: the ``usual`` with a body and a grip of its own."""
    rng = np.random.default_rng([seed, number, 1])
    body = {name: getattr(usual, name) * math.exp(BODIES * rng.standard_normal()) for name in VARIED}
    return replace(usual, **body, pitch_deg=usual.pitch_deg + 10 * rng.standard_normal())


def random_stroke(seed: int, number: int, take: int) -> tuple[float, float]:
    """Return speed, mm/s, and force, N, of a stroke of surface ``number``."""
    rng = np.random.default_rng([seed, number, 2, take])
    return round(_between(rng, *SPEEDS_MM_S), 1), round(_between(rng, *FORCES_N), 3)


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two, log-uniform."""
    return float(low * (high / low) ** rng.random())


def _roughness(rng: np.random.Generator) -> Texture:
    stretch = _between(rng, 2, 16) if rng.random() < 0.25 else 1.0
    rms, beta = _between(rng, 0.018, 0.045), rng.uniform(2.1, 4.1)
    return Roughness(rms, beta, _between(rng, 0.03, 0.06), rng.uniform(6, 9.9), stretch)


def _grating(rng: np.random.Generator) -> Texture:
    period = _between(rng, 0.8, 10)
    wander = period * _between(rng, 0.01, 0.3) if rng.random() < 0.7 else 0.0
    height = period * _between(rng, 0.0015, 0.03)
    angle = rng.choice((0.0, 90.0, rng.uniform(0, 180)))
    return Grating(period, height, angle, _between(rng, 0.7, 4), wander)


def _weave(rng: np.random.Generator) -> Texture:
    period = _between(rng, 0.7, 4)
    return Weave(period, period * _between(rng, 0.007, 0.036))


def _particles(rng: np.random.Generator) -> Texture:
    radius = _between(rng, 0.25, 2.2)
    density = _between(rng, 0.1, 1.5) / (math.pi * radius**2)
    order = rng.choice((0.0, 1.0, rng.random()))
    if rng.random() < 0.3:  # holes
        depth = radius * _between(rng, 0.024, 0.14)
        return Particles(density, radius, -depth, order, _between(rng, 0.1, 0.3))
    return Particles(density, radius, radius * _between(rng, 0.007, 0.14), order)


def _cells(rng: np.random.Generator) -> Texture:
    size = _between(rng, 1.2, 5)
    height = size * _between(rng, 0.0024, 0.014)
    return Cells(size, height, height * rng.uniform(0, 0.5))


_TEXTURES: tuple[Callable[[np.random.Generator], Texture], ...] = (
    _grating, _weave, _particles, _cells, _roughness
)  # fmt: skip


def _appearance(rng: np.random.Generator) -> Appearance:
    colour = colorsys.hsv_to_rgb(rng.random(), rng.uniform(0, 0.9), rng.uniform(0.1, 0.7))
    shade = rng.uniform(0.2, 1.0)
    gloss = rng.uniform(0, 0.15) if rng.random() < 0.5 else 0.0
    streak = _between(rng, 2, 16) if rng.random() < 0.25 else 1.0
    hollow = (shade * colour[0], shade * colour[1], shade * colour[2])
    return Appearance(colour, hollow, _between(rng, 0.01, 0.35), _between(rng, 1, 8), streak, gloss)
