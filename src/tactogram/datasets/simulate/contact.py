"""Contact mechanics: skin, a resonant contact, and stick-slip friction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft, rfft2, rfftfreq

from tactogram.datasets.simulate.slide import COLUMNS, compiled
from tactogram.datasets.simulate.stroke import Stroke
from tactogram.datasets.simulate.surfaces import MM_PER_PIXEL, Surface, felt_heights, frequencies, inverse


@dataclass(frozen=True)
class Bristles:
    """Stiffness, damping and viscosity of LuGre friction: N/m, N s/m, N s/m."""

    sigma0: float
    sigma1: float
    sigma2: float


SKIN = Bristles(1e4, 3.0, 0.2)
"""Our assumption: skin and plastic are ten times as compliant."""


@dataclass(frozen=True)
class Contactor:
    """Contactor: a finger pad, or a pen held in the hand."""

    name: str
    radius_mm: float  # of the contact, over which heights are averaged
    ridges_mm: float  # period of the fingerprint
    ridges: float  # its modulation of the pressure, 0..1
    # Normal contact m z'' + b (z' - u') + k (z - u) = 0.
    mass_kg: float
    stiffness_n_m: float
    damping_n_s_m: float
    # Dragged mass, and stiffness and damping of the hand that drags it.
    grip_mass_kg: float
    grip_n_m: float
    grip_n_s_m: float
    force_n: float  # usual normal force
    pitch_deg: float  # inclination of the sensor on it, backwards about y
    passed: float = 1.0  # share of a height that reaches it
    pushed: float = (
        1.0  # share of the push of the surface's slopes that moves it; the rest bends tool or skin
    )
    response_db: tuple[
        tuple[float, float], ...
    ] = ()  # of tool, hand and sensor: gain, dB, at frequencies, Hz


# Damping and stiffness of the finger are of the order of Wiertlewski & Hayward 2012 (elastic below, viscous above about
# 100 Hz), of the pen's grip within those compiled from Fu & Cavusoglu 2012; masses include a sensor of a few grams.
FINGER = Contactor("finger", 2.0, 0.45, 0.3, 0.004, 1000.0, 1.4, 0.006, 900.0, 2.0, 0.7, 25.0)
PEN = Contactor("pen", 0.25, 1.0, 0.0, 0.012, 4000.0, 2.5, 0.015, 700.0, 2.5, 0.9, 40.0)

# Fitted to aggregates of recordings (`random_surfaces`): over self-affine roughness spectra hardly move with
# speed and grow with it, and little with force; resonances of tool, hand and sensor stay where they are. The steel tip
# of a stylus touches over some 0.1 mm. No such aggregates were found for a bare finger with an accelerometer: it has
# the same roughness under it and, softer and wider, a spectrum that moves more (Manfredi et al. 2014, J. Neurophysiol.
# 111:1792; Greenspon et al. 2020, J. R. Soc. Interface 17:20190892).
STYLUS = Contactor(
    "stylus", 0.08, 1.0, 0.0, 0.012, 1200.0, 5.0, 0.015, 700.0, 2.5, 0.9, 40.0, passed=0.25, pushed=0.14,
    response_db=((20, 22), (40, 16), (80, 13), (130, 16), (200, 16), (300, 14.5), (400, 10), (480, 0)),
)  # fmt: skip
FINGERTIP = Contactor(
    "finger", 0.2, 0.45, 0.3, 0.004, 700.0, 2.5, 0.006, 900.0, 2.0, 0.7, 25.0, passed=0.25, pushed=0.14,
    response_db=((20, 18), (60, 13), (200, 13), (400, 11), (1000, 7)),
)  # fmt: skip


@dataclass(frozen=True)
class ContactSignals:
    """Signals at the contact, float64, shape (time,) each."""

    along: NDArray[np.float64]  # acceleration of the contactor along the stroke, m/s^2
    across: NDArray[np.float64]  # across it in the plane
    normal: NDArray[np.float64]  # out of the plane
    friction_n: NDArray[np.float64]  # tangential force
    force_n: NDArray[np.float64]  # normal force; 0 while the contactor is off the surface
    place_m: NDArray[np.float64]  # position of the contactor along the stroke


def feel(
    surface: Surface,
    contactor: Contactor,
    stroke: Stroke,
    *,
    start_mm: tuple[float, float],
    direction_deg: float,
    wear: float = 1.0,
    bristles: Bristles = SKIN,
) -> ContactSignals:
    """Return the signals of ``contactor`` on ``stroke`` over ``surface``.

    The surface is read in space, at the position of the contactor, so a spatial frequency k at speed v is felt at v k,
    and vibration grows with speed only by this "systematic upward multiplicative shift in the frequency composition",
    which "accounts for the increase in intensity" (Greenspon, McLellan, Lieber, Bensmaia 2019). The relief of a soft
    surface yields: of two springs in series, the contactor's is bent by k_s / (k_s + k_c) of a height.

    The stroke begins at ``start_mm`` on the surface, in ``direction_deg`` from x; ``wear`` scales the heights.
    """
    angle = np.deg2rad(direction_deg)
    left = surface.stiffness_n_m / (surface.stiffness_n_m + contactor.stiffness_n_m)
    k = left * contactor.stiffness_n_m
    b = contactor.damping_n_s_m + surface.loss * np.sqrt(k * contactor.mass_kg)
    columns = compiled()(
        felt_spline(surface, contactor),
        1e-3 * wear * left * contactor.passed,
        1e-3 * MM_PER_PIXEL,
        1 / stroke.rate,
        1e-3 * stroke.path_mm,
        1e-3 * stroke.sideways_mm,
        stroke.force_n,
        (1e-3 * start_mm[0], 1e-3 * start_mm[1]),
        (float(np.cos(angle)), float(np.sin(angle))),
        (contactor.mass_kg, k, b),
        (contactor.grip_mass_kg, contactor.grip_n_m, contactor.grip_n_s_m, contactor.pushed),
        (surface.friction, surface.friction * surface.stiction, 1e-3 * surface.stribeck_mm_s),
        (bristles.sigma0, bristles.sigma1, bristles.sigma2),
    )
    return ContactSignals(**dict(zip(COLUMNS, columns, strict=True)))


def responded(acceleration: NDArray[np.float64], rate: float, contactor: Contactor) -> NDArray[np.float64]:
    """Return an acceleration, (axis, time), after the response of tool, hand and sensor, which no speed moves.

    The gain is interpolated over the logarithm of the frequency and constant beyond its ends, without delay.
    """
    if not contactor.response_db:
        return acceleration
    hertz, gain = np.array(contactor.response_db).T
    x = np.maximum(rfftfreq(acceleration.shape[1], 1 / rate), hertz[0])
    curve = 10 ** (np.interp(np.log(x), np.log(hertz), gain) / 20)
    return np.asarray(irfft(rfft(acceleration) * curve, acceleration.shape[1]))


@lru_cache(maxsize=4)
def felt_spline(surface: Surface, contactor: Contactor) -> NDArray[np.float32]:
    """Return the heights as the contactor feels them, mm, as coefficients of a cubic B-spline over the periodic patch.

    float32, shape (row, column). The B-spline's own transform, ((2 + cos(2 pi k)) / 3 per direction), is divided out.
    """
    ky, kx = frequencies()
    spread = (2 + np.cos(2 * np.pi * ky * MM_PER_PIXEL)) * (2 + np.cos(2 * np.pi * kx * MM_PER_PIXEL)) / 9
    passed = transmission(contactor, np.hypot(ky, kx))
    return inverse(rfft2(felt_heights(surface)) * passed / spread).astype(np.float32)


def transmission(contactor: Contactor, k: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the share of a height of ``k`` cycles per mm that passes the contact, float64, the shape of ``k``.

    The pressure under a round contact (Hertz) averages heights with 3 (sin q - q cos q) / q^3, q = 2 pi a k, of which 1
    / (1 + q^2 / 10) is the envelope: equal for small q, without the zeros that no real contact has. Ridges modulate the
    pressure and so pass detail of their own period (Scheibert, Leurent, Prevost, Debregeas 2009, Science 323:1503).
    """

    def averaged(k: NDArray[np.float64]) -> NDArray[np.float64]:
        return 1 / (1 + (2 * np.pi * contactor.radius_mm * k) ** 2 / 10)

    if not contactor.ridges:
        return averaged(k)
    return averaged(k) + contactor.ridges / 2 * averaged(k - 1 / contactor.ridges_mm)
