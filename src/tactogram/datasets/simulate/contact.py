"""What the contactor feels: the surface through its skin, a resonant contact, friction that sticks and slips."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates
from scipy.signal import bilinear, lfilter

from tactogram.datasets.simulate.stroke import Stroke
from tactogram.datasets.simulate.surfaces import MM_PER_PIXEL, SIZE, Surface, height_field

STIFFNESS_0, DAMPING_1, VISCOSITY_2 = 1e4, 3.0, 0.2
"""LuGre bristles (Canudas de Wit et al. 1995): N/m, N s/m, N s/m. The canonical 1e5 N/m is for machines; skin and
plastic on a 5 g contactor give way more."""


@dataclass(frozen=True)
class Contactor:
    """What touches: a finger pad, or a pen held in the hand.

    Parameters
    ----------
    name : str
    radius_mm : float
        What is smaller than this is averaged away (Gaussian contact).
    ridges_mm : float or None
        Period of the fingerprint, which passes detail that the pad averages (Scheibert et al. 2009, Science 323).
    mass_kg, damping_n_s_m, stiffness_n_m : float
        Normal contact m z'' + b (z' - u') + k (z - u) = 0. Finger: Wiertlewski & Hayward 2012, elastic below about
        100 Hz; pen: Fu & Cavusoglu 2012.
    tangential_mass_kg, grip_n_m, grip_n_s_m : float
        What is dragged, and the hand that drags it.
    """

    name: str
    radius_mm: float
    ridges_mm: float | None
    mass_kg: float
    damping_n_s_m: float
    stiffness_n_m: float
    tangential_mass_kg: float
    grip_n_m: float
    grip_n_s_m: float
    force_n: float


FINGER = Contactor("finger", 0.45, 0.45, 0.002, 1.4, 1000.0, 0.006, 900.0, 2.0, 0.7)
PEN = Contactor("pen", 0.12, None, 0.012, 1.6, 4000.0, 0.015, 700.0, 2.5, 0.9)
CONTACTORS = {c.name: c for c in (FINGER, PEN)}


@dataclass(frozen=True)
class Felt:
    """What happens at the contact, float64, shape (time,) each.

    Parameters
    ----------
    along, across, normal : m/s^2
        Acceleration of the contactor along the stroke, across it in the plane, and out of it.
    friction_n, force_n : N
    """

    along: NDArray[np.float64]
    across: NDArray[np.float64]
    normal: NDArray[np.float64]
    friction_n: NDArray[np.float64]
    force_n: NDArray[np.float64]


def feel(
    surface: Surface,
    contactor: Contactor,
    stroke: Stroke,
    *,
    start_mm: tuple[float, float],
    direction_deg: float,
    wear: float = 1.0,
) -> Felt:
    """Return what ``contactor`` feels on ``stroke`` over ``surface``.

    The surface is read in space, so that a spatial frequency k at speed v is felt at v k, and the vibration grows
    with speed as "a systematic upward multiplicative shift in the frequency composition" (Greenspon et al. 2019).

    Parameters
    ----------
    start_mm : (float, float)
        Where the stroke begins on the surface.
    direction_deg : float
        Its direction; 0 is along x.
    wear : float
        Heights are multiplied by it.
    """
    angle = np.deg2rad(direction_deg)
    x = start_mm[0] + stroke.path_mm * np.cos(angle)
    y = start_mm[1] + stroke.path_mm * np.sin(angle)
    height, along, across = _felt_fields(surface, contactor)
    at = np.stack([y, x]) / MM_PER_PIXEL
    # Moved sideways half a turn, a path that comes back is not the same twice.
    u = wear * 1e-3 * map_coordinates(height, at, order=1, mode="grid-wrap")
    slope_x = wear * map_coordinates(along, at, order=1, mode="grid-wrap")
    slope_y = wear * map_coordinates(across, at, order=1, mode="grid-wrap")
    slope_along = slope_x * np.cos(angle) + slope_y * np.sin(angle)
    slope_across = slope_y * np.cos(angle) - slope_x * np.sin(angle)

    k = 1 / (1 / contactor.stiffness_n_m + 1 / surface.stiffness_n_m)
    give = k / contactor.stiffness_n_m * (1 - surface.damping)
    normal, press = _resonate(give * u, contactor, k, stroke.rate)
    force = np.maximum(stroke.force_n + press, 0.02 * stroke.force_n)
    push = -np.clip(slope_along, -1.5, 1.5) * force * (1 - surface.damping)
    acceleration, friction = _drag()(
        stroke.speed_mm_s * 1e-3,
        force,
        push,
        1 / stroke.rate,
        contactor.tangential_mass_kg,
        contactor.grip_n_m,
        contactor.grip_n_s_m,
        surface.friction,
        surface.friction * surface.stiction,
        surface.stribeck_mm_s * 1e-3,
        STIFFNESS_0,
        DAMPING_1,
        VISCOSITY_2,
    )
    sideways, _ = _resonate(
        np.cumsum(slope_across * stroke.speed_mm_s) * 1e-3 / stroke.rate * 0.3 * give,
        contactor,
        k,
        stroke.rate,
    )
    return Felt(acceleration, sideways, normal, friction, force)


@cache
def _felt_fields(
    surface: Surface, contactor: Contactor
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32]]:
    """Return the height (mm) that the contactor feels, and its slopes along x and y, over the periodic patch."""
    k = np.fft.fftfreq(SIZE, MM_PER_PIXEL)
    ky, kx = k[:, None], k[None, : SIZE // 2 + 1]
    radius = np.hypot(ky, kx)
    passed = np.exp(-2 * (np.pi * contactor.radius_mm * radius) ** 2)
    if contactor.ridges_mm:
        detail = np.exp(-0.5 * ((radius - 1 / contactor.ridges_mm) * contactor.ridges_mm / 0.35) ** 2)
        passed = np.maximum(passed, 0.25 * detail)
    spectrum = np.fft.rfft2(height_field(surface)) * passed

    def back(s: NDArray[np.complex128]) -> NDArray[np.float32]:
        return np.fft.irfft2(s, s=(SIZE, SIZE)).astype(np.float32)

    return back(spectrum), back(2j * np.pi * kx * spectrum), back(2j * np.pi * ky * spectrum)


def _resonate(
    u: NDArray[np.float64], contactor: Contactor, k: float, rate: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return acceleration (m/s^2) and force (N) of a mass on spring and damper over heights ``u`` (m)."""
    m, b = contactor.mass_kg, contactor.damping_n_s_m
    moved, taken = bilinear([b, k], [m, b, k], rate)
    z = lfilter(moved, taken, u - u[0]) + u[0]
    acceleration = np.zeros_like(z)
    acceleration[1:-1] = (z[2:] - 2 * z[1:-1] + z[:-2]) * rate**2
    return acceleration, m * acceleration


@cache
def _drag() -> Callable[..., Any]:
    """Return the compiled friction: compiled when first used, so that importing costs nothing."""
    from numba import njit

    return njit(cache=True)(drag)


def drag(
    speed: NDArray[np.float64],
    force: NDArray[np.float64],
    push: NDArray[np.float64],
    dt: float,
    mass: float,
    spring: float,
    damper: float,
    mu_c: float,
    mu_s: float,
    v_s: float,
    sigma0: float,
    sigma1: float,
    sigma2: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return acceleration (m/s^2) and friction (N) of a mass dragged by a spring over LuGre friction.

    Canudas de Wit, Olsson, Astrom, Lischinsky 1995: z' = v - sigma0 |v| z / g(v), F = sigma0 z + sigma1 z' + sigma2 v,
    g(v) = F_n (mu_c + (mu_s - mu_c) exp(-(v / v_s)^2)). Bristle and mass are advanced together, implicit in both,
    with |v| / g(v) of the step before: stable at any step, one division per sample.

    Parameters
    ----------
    speed : float64 array, shape (time,), m/s
        Of the hand.
    force, push : float64 arrays, shape (time,), N
        Normal force; tangential force by the slopes of the surface.
    dt : float, s
    mass, spring, damper : kg, N/m, N s/m
        The contactor, and the grip between it and the hand.
    mu_c, mu_s, v_s, sigma0, sigma1, sigma2
        Friction, in SI units.
    """
    n = len(speed)
    acceleration = np.empty(n)
    friction = np.empty(n)
    # Begin in the middle of sliding: bristles bent, the grip stretched by the friction.
    v = speed[0]
    side = 1.0 if v >= 0 else -1.0
    z = side * force[0] * mu_c / sigma0 if v != 0 else 0.0
    stretch = (sigma0 * z + sigma2 * v) / spring
    for i in range(n):
        g = force[i] * (mu_c + (mu_s - mu_c) * np.exp(-((v / v_s) ** 2)))
        a = dt * sigma0 * abs(v) / g
        keep = 1.0 / (1.0 + a)
        # z' = v - (a / dt) z, implicit: z_new = keep (z + dt v_new); friction = f0 + f1 v_new.
        f0 = sigma0 * keep * z + sigma1 * (keep - 1.0) * z / dt
        f1 = sigma0 * keep * dt + sigma1 * keep + sigma2
        drive = spring * (stretch + dt * speed[i]) + damper * speed[i] + push[i]
        v_new = (mass / dt * v + drive - f0) / (mass / dt + spring * dt + damper + f1)
        friction[i] = f0 + f1 * v_new
        acceleration[i] = (v_new - v) / dt
        z = keep * (z + dt * v_new)
        stretch += dt * (speed[i] - v_new)
        v = v_new
    return acceleration, friction
