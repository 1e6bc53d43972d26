"""Surfaces, and fingers and pens that stroke them, drawn at random: populations to train on, not models of materials.

Sizes, heights and mechanics are log-uniform; colours say nothing of the heights, but hollows, light and spots show
them. `WIDE` has ranges that include most surfaces of `materials`. `FITTED` resembles recordings: by a stylus it has the
level and spread, the centroid and slope of the spectrum, and the powers of speed and force with which they grow, of the
100 materials of the Penn Haptic Texture Toolkit (Culbertson et al. 2014), as aggregates: ``python -m benchmarks
real_surfaces`` compares them. Self-affine roughness has them by itself: where heights fall
as k^-beta, a speed multiplies all of the spectrum by v^(beta - 1) (beta from 2 to 3: Persson et al. 2005, J. Phys.
Condens. Matter 17:R1).
"""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tactogram.datasets.simulate.contact import FINGER, FINGERTIP, PEN, STYLUS, Contactor
from tactogram.datasets.simulate.surfaces import (
    Appearance,
    Cells,
    Colour,
    Grating,
    Particles,
    Roughness,
    Surface,
    Texture,
    Weave,
    in_relief,
)

SPEEDS_MM_S = (30.0, 400.0)
"""Range of stroking speeds."""
FORCES_N = (0.2, 3.0)
"""Range of mean normal forces."""


@dataclass(frozen=True)
class Population:
    """Ranges of what is drawn.

    Attributes
    ----------
    name : str
        Begins the names of its surfaces.
    textures : tuple of float
        Shares of the surfaces with none to three textures.
    relief : float
        Heights of these, as a share of those of `WIDE`.
    rms_mm, beta, low, high : tuple of float
        Of the roughness that every surface has, as of `Roughness`.
    contactors : tuple of Contactor
        They take turns over a surface's strokes, or one of them strokes each surface.
    by_turns : bool
    bodies : float
        Standard deviation of the logarithms of a contactor's size, mass (sensor included), stiffness and damping.
    """

    name: str
    textures: tuple[float, float, float, float]
    relief: float
    rms_mm: tuple[float, float]
    beta: tuple[float, float]
    low: tuple[float, float]
    high: tuple[float, float]
    contactors: tuple[Contactor, Contactor]
    by_turns: bool
    bodies: float


WIDE = Population(
    "random",
    (0.15, 0.45, 0.3, 0.1),
    1.0,
    (0.002, 0.06),
    (0.8, 2.2),
    (0.05, 0.4),
    (3, 6),
    (FINGER, PEN),
    False,
    0.25,
)
FITTED = Population(
    "fitted", (0.75, 0.2, 0.05, 0.0), 0.24, (0.018, 0.045), (2.1, 4.1), (0.03, 0.06), (6, 9.9), (FINGERTIP, STYLUS),
    True, 0.35,
)  # fmt: skip


@lru_cache(maxsize=64)
def random_surface(seed: int, number: int, population: Population = WIDE) -> Surface:
    """Return surface ``number`` of those that ``seed`` draws: up to three textures and fine roughness."""
    rng = np.random.default_rng([seed, number, 0])
    drawn = [
        _TEXTURES[rng.integers(len(_TEXTURES))](rng, population)
        for _ in range(rng.choice(4, p=population.textures))
    ]
    if population.relief != 1:
        drawn = [t if isinstance(t, Roughness) else in_relief(t, population.relief) for t in drawn]
    hard = rng.random() < 0.4
    return Surface(
        f"{population.name}-{seed}-{number:05d}",
        (*drawn, _roughness(rng, population)),
        rng.uniform(0.25, 1.0),
        rng.uniform(1.05, 1.35),
        rng.uniform(5, 20),
        stiffness_n_m=1e5 if hard else _between(rng, 500, 5e4),
        loss=0.0 if hard else rng.uniform(0, 0.9),
        look=_appearance(rng),
    )


def random_contactor(seed: int, number: int, population: Population = WIDE, take: int = 0) -> Contactor:
    """Return what strokes surface ``number``: a finger, or as often a pen, with a body and a grip of its own."""
    rng = np.random.default_rng([seed, number, 1])
    drawn = rng.random() >= 0.5
    base = population.contactors[take % 2 if population.by_turns else int(drawn)]

    def varied(value: float) -> float:
        return float(value * math.exp(population.bodies * rng.standard_normal()))

    return replace(
        base,
        radius_mm=varied(base.radius_mm),
        ridges_mm=varied(base.ridges_mm),
        mass_kg=varied(base.mass_kg),
        stiffness_n_m=varied(base.stiffness_n_m),
        damping_n_s_m=varied(base.damping_n_s_m),
        grip_mass_kg=varied(base.grip_mass_kg),
        grip_n_m=varied(base.grip_n_m),
        grip_n_s_m=varied(base.grip_n_s_m),
        pitch_deg=base.pitch_deg + 10 * rng.standard_normal(),
    )


def random_stroke(seed: int, number: int, take: int) -> tuple[float, float]:
    """Return speed, mm/s, and force, N, of a stroke of surface ``number``."""
    rng = np.random.default_rng([seed, number, 2, take])
    return round(_between(rng, *SPEEDS_MM_S), 1), round(_between(rng, *FORCES_N), 3)


def _between(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two, log-uniform."""
    return float(low * (high / low) ** rng.random())


def _roughness(rng: np.random.Generator, of: Population) -> Texture:
    stretch = _between(rng, 2, 16) if rng.random() < 0.25 else 1.0
    return Roughness(
        _between(rng, *of.rms_mm),
        rng.uniform(*of.beta),
        _between(rng, *of.low),
        rng.uniform(*of.high),
        stretch,
    )


def _grating(rng: np.random.Generator, of: Population) -> Texture:
    period = _between(rng, 0.8, 10)
    wander = period * _between(rng, 0.01, 0.3) if rng.random() < 0.7 else 0.0
    height = period * _between(rng, 0.006, 0.12)
    return Grating(
        period, height, rng.choice((0.0, 90.0, rng.uniform(0, 180))), _between(rng, 0.7, 4), wander
    )


def _weave(rng: np.random.Generator, of: Population) -> Texture:
    period = _between(rng, 0.7, 4)
    return Weave(period, period * _between(rng, 0.03, 0.15))


def _particles(rng: np.random.Generator, of: Population) -> Texture:
    radius = _between(rng, 0.25, 2.2)
    density = _between(rng, 0.1, 1.5) / (math.pi * radius**2)
    order = rng.choice((0.0, 1.0, rng.random()))
    if rng.random() < 0.3:  # holes
        return Particles(density, radius, -radius * _between(rng, 0.1, 0.6), order, _between(rng, 0.1, 0.3))
    return Particles(density, radius, radius * _between(rng, 0.03, 0.6), order)


def _cells(rng: np.random.Generator, of: Population) -> Texture:
    size = _between(rng, 1.2, 5)
    height = size * _between(rng, 0.01, 0.06)
    return Cells(size, height, height * rng.uniform(0, 0.5))


_TEXTURES: tuple[Callable[[np.random.Generator, Population], Texture], ...] = (
    _grating,
    _weave,
    _particles,
    _cells,
    _roughness,
)


def _appearance(rng: np.random.Generator) -> Appearance:
    colour = _colour(rng.random(), rng.uniform(0, 0.9), rng.uniform(0.1, 0.7))
    shade = rng.uniform(0.2, 1.0)
    gloss = rng.uniform(0, 0.15) if rng.random() < 0.5 else 0.0
    streak = _between(rng, 2, 16) if rng.random() < 0.25 else 1.0
    hollow = (shade * colour[0], shade * colour[1], shade * colour[2])
    return Appearance(colour, hollow, _between(rng, 0.01, 0.35), _between(rng, 1, 8), streak, gloss)


def _colour(hue: float, saturation: float, value: float) -> Colour:
    return colorsys.hsv_to_rgb(hue, saturation, value)
