"""Materials of the simulated sets, a row each of ``surfaces.csv``: imagined formulas, not measurements.

Empty cells have the default. ``textures`` are added up; each is a class of `tactogram_simulate.surfaces` and its
numbers. ``made`` and ``fine_um`` are of `Plate`. Everyday surfaces have, written by ``python -m
benchmarks.set_everyday``, the share of their heights that is ``felt``, and the rms and beta of the ground besides.
Their level and the slope of their spectrum are set to means of real materials of their kind (`KINDS`); kinds and
further names are those of `tactogram.datasets.everyday`.

Only a photograph of the study's own plates is known. These are textures with which metal plates are sold; periods,
heights and friction are our assumptions, typical of such treatments.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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

TEXTURES = {each.__name__: each for each in (Grating, Weave, Particles, Roughness, Cells)}
FINEST_PER_MM, COARSEST_PER_MM = 50.0, 5.0
"""Cycles per mm covered by `Plate.fine_um`: from the limit of height fields to a fiftieth of a millimetre."""
_STEP_MM, _STEPS = 0.004, 2**15


@cache
def rows(set_name: str) -> tuple[Mapping[str, str], ...]:
    """Return the rows of a set, without empty cells."""
    text = files("tactogram_simulate").joinpath("surfaces.csv").read_text(encoding="utf-8")
    filled = ({name: cell for name, cell in row.items() if cell} for row in csv.DictReader(text.splitlines()))
    return tuple(row for row in filled if row["set"] == set_name)


def surfaces_of(set_name: str) -> tuple[Surface, ...]:
    """Return the materials of a set, as drawn."""
    return tuple(_surface(row) for row in rows(set_name))


def numbers(cell: str) -> list[Any]:
    """Return the numbers in a cell, whole ones as int."""
    return [json.loads(text) for text in cell.split()]


def _surface(row: Mapping[str, str]) -> Surface:
    own = {f.name for kind in (Surface, Appearance) for f in fields(kind)} - {
        "name",
        "textures",
        "felt",
        "look",
    }
    values: dict[str, Any] = {
        name: tuple(numbers(cell)) if name in ("colour", "hollow") else numbers(cell)[0]
        for name, cell in row.items()
        if name in own
    }
    look = {f.name: values.pop(f.name) for f in fields(Appearance) if f.name in values}
    textures = tuple(_texture(*text.split(maxsplit=1)) for text in row["textures"].split(" + "))
    return Surface(row["name"], textures, **values, look=Appearance(**look))


def _texture(kind: str, cell: str) -> Texture:
    texture: Texture = TEXTURES[kind](*numbers(cell))
    return texture


STROKING_30, STROKING_9 = surfaces_of("stroking30"), surfaces_of("stroking9")
"""Named after the materials of Saga et al."""


class Kind(NamedTuple):
    """Level and slope that the surfaces of a kind are set to.

    They are the mean of `tactogram.datasets.everyday.MEASURED` real materials, drawn towards that of all 60 by the
    weight of four more.

    Attributes
    ----------
    level_db : float
        Of a stylus at 120 mm/s and 1 N, 20 to 480 Hz, dB re 1 m/s^2.
    slope_db : float
        Of the spectrum's density, dB per octave.
    """

    level_db: float
    slope_db: float


KINDS: Mapping[str, Kind] = {
    "fabric": Kind(-2.2, -5.1),
    "carpet": Kind(4.9, -6.5),
    "paper": Kind(-1.6, -3.9),
    "leather": Kind(-2.0, -5.7),
    "foam": Kind(0.6, -4.9),
    "plastic": Kind(0.1, -3.9),
    "mineral": Kind(8.3, -2.2),
    "metal": Kind(-0.1, -4.2),
    "other": Kind(0.5, -4.5),
}


def as_measured(surface: Surface, felt: float, rms_mm: float, beta: float) -> Surface:
    """Return a surface of which a share is felt, and of a ground besides: the spectra of real materials are smooth."""
    return replace(surface, felt=felt, ground=Roughness(rms_mm, beta, 0.05, 8.0))


ROWS = {row["name"]: row for row in rows("everyday")}
DRAWN = surfaces_of("everyday")
EVERYDAY = tuple(
    as_measured(
        surface,
        *numbers(" ".join(ROWS[surface.name][name] for name in ("felt", "ground_rms_mm", "ground_beta"))),
    )
    for surface in DRAWN
)


@dataclass(frozen=True)
class Plate:
    """A metal plate.

    ``made`` describes its manufacture. ``fine_um`` is the rms height of the roughness that is too fine for a height
    field, between `COARSEST_PER_MM` and `FINEST_PER_MM`, its power falling as k^-2.
    """

    surface: Surface
    made: str
    fine_um: float

    @property
    def name(self) -> str:
        """Name in recordings and ratings."""
        return self.surface.name


# Friction of a finger on metal: high on polished plates, all of which the skin touches, low where fine asperities carry
# the finger (Derler & Gerhardt 2012, Tribol. Lett. 45:1).
PLATES = tuple(
    Plate(surface, row["made"], float(row["fine_um"]))
    for surface, row in zip(surfaces_of("ultrasonic"), rows("ultrasonic"), strict=True)
)
"""``plate01`` to ``plate12``."""


def fine_heights(
    plate: Plate, contactor: Contactor, place_m: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return the finest roughness under a contact at each position of its path, m, float64, shape (time,).

    The asperities under a contact are independent, so their mean is smaller than one of them by the root of their
    number: pi (a k)^2 at k cycles per mm under a contact of radius a.
    """
    k = np.fft.rfftfreq(_STEPS, _STEP_MM)
    inside = (k >= COARSEST_PER_MM) & (k <= FINEST_PER_MM)
    amplitude = np.zeros_like(k)
    amplitude[inside] = 1 / k[inside]
    noise = np.fft.rfft(rng.standard_normal(_STEPS)) * amplitude
    rms = np.fft.irfft(noise, _STEPS).std()
    under = np.maximum(np.sqrt(np.pi) * contactor.radius_mm * k, 1.0)
    heights = 1e-6 * plate.fine_um / rms * np.fft.irfft(noise / under, _STEPS)
    grid_mm = np.arange(_STEPS) * _STEP_MM
    return np.asarray(np.interp(1e3 * place_m, grid_mm, heights, period=_STEPS * _STEP_MM))
