"""Twelve metal plates with machined and treated surfaces: the samples of the ultrasonic study, simulated.

Only a photograph of the study's own plates is known. These are textures with which metal plates are sold; periods,
heights and friction are our assumptions, typical of such treatments.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.simulate.contact import Contactor
from tactogram.datasets.simulate.materials import rows, surfaces_of
from tactogram.datasets.simulate.surfaces import Surface

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
    at = np.arange(_STEPS) * _STEP_MM
    return np.asarray(np.interp(1e3 * place_m, at, heights, period=_STEPS * _STEP_MM))
