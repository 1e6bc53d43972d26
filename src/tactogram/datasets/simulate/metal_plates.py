"""Twelve metal plates with machined and treated surfaces: the samples of the ultrasonic study, simulated.

Only a photograph of the study's own plates is known. These are textures with which metal plates are sold; periods,
heights and friction are our assumptions, typical of such treatments.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.simulate.contact import Contactor
from tactogram.datasets.simulate.surfaces import Appearance, Grating, Particles, Roughness, Surface

FINEST_PER_MM, COARSEST_PER_MM = 50.0, 5.0
"""Cycles per mm covered by `Plate.fine_um`: from the limit of height fields to a fiftieth of a millimetre."""
_STEP_MM, _STEPS = 0.004, 2**15


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


def _plate(
    number: int,
    made: str,
    textures: tuple[Grating | Particles | Roughness, ...],
    *,
    fine_um: float,
    friction: float,
    stiction: float = 1.1,
    gloss: float = 0.2,
) -> Plate:
    look = Appearance((0.36, 0.36, 0.38), (0.22, 0.22, 0.23), 0.03, 2.0, gloss=gloss)
    name = f"plate{number:02d}"
    return Plate(Surface(name, textures, friction, stiction, 15.0, 1e6, look=look), made, fine_um)


# Friction of a finger on metal: high on polished plates, all of which the skin touches, low where fine asperities carry
# the finger (Derler & Gerhardt 2012, Tribol. Lett. 45:1).
PLATES = (
    _plate(
        1, "mirror-polished", (Roughness(0.0001, 2.0, 0.1, 5),),
        fine_um=0.05, friction=0.75, stiction=1.5, gloss=0.9,
    ),
    _plate(
        2, "buffed", (Roughness(0.0005, 2.0, 0.1, 6),),
        fine_um=0.3, friction=0.45, stiction=1.2, gloss=0.6,
    ),
    _plate(
        3, "brushed across the stroke", (Roughness(0.0025, 1.0, 0.5, 8, 12.0),),
        fine_um=1.2, friction=0.32,
    ),
    _plate(
        4, "sandblasted, fine grit", (Roughness(0.004, 1.2, 0.5, 8),),
        fine_um=2.5, friction=0.30, gloss=0.05,
    ),
    _plate(
        5, "sandblasted, coarse grit", (Roughness(0.022, 1.2, 0.4, 6),),
        fine_um=6.0, friction=0.42, gloss=0.02,
    ),
    _plate(
        6, "spark-eroded", (Roughness(0.012, 0.8, 0.8, 8), Particles(3.0, 0.25, -0.03)),
        fine_um=5.0, friction=0.38, gloss=0.02,
    ),
    _plate(
        7, "etched grid, 0.8 mm", (Grating(0.8, 0.06, 0, 3.0), Grating(0.8, 0.06, 90, 3.0)),
        fine_um=1.5, friction=0.36,
    ),
    _plate(
        8, "knurled, 1.2 mm diamonds", (Grating(1.2, 0.22, 45, 2.5), Grating(1.2, 0.22, -45, 2.5)),
        fine_um=2.0, friction=0.55,
    ),
    _plate(
        9, "grooved, 2.5 mm ridges", (Grating(2.5, 0.30, 0, 2.0),),
        fine_um=0.8, friction=0.40,
    ),
    _plate(
        10, "punched, 3 mm holes", (Particles(0.05, 1.5, -0.45, 1.0, 0.35),),
        fine_um=0.4, friction=0.45, gloss=0.4,
    ),
    _plate(
        11, "embossed, 6 mm studs", (Particles(0.03, 2.4, 0.60, 1.0), Roughness(0.0008, 2.0, 0.1, 6)),
        fine_um=0.5, friction=0.42, gloss=0.4,
    ),
    _plate(
        12, "cast and hammered",
        (Roughness(0.10, 2.5, 0.08, 1.0), Particles(0.12, 1.6, 0.25, 0.3), Roughness(0.012, 1.2, 0.5, 6)),
        fine_um=4.0, friction=0.48, gloss=0.05,
    ),
)  # fmt: skip
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
    at = np.arange(_STEPS) * _STEP_MM
    return np.asarray(np.interp(1e3 * place_m, at, heights, period=_STEPS * _STEP_MM))
