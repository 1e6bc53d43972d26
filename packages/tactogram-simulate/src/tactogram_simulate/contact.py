"""Contact mechanics: skin, a resonant contact, and stick-slip friction, in a compiled loop of one step per sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, rfft, rfft2, rfftfreq

from tactogram_simulate.stroke import Stroke
from tactogram_simulate.surfaces import MM_PER_PIXEL, Surface, felt_heights, frequencies, inverse


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


COLUMNS = ("along", "across", "normal", "friction_n", "force_n", "place_m")


@cache
def compiled() -> Callable[..., NDArray[np.float64]]:
    """Return `slide`, compiled on first use, so that imports stay fast."""
    from numba import njit

    loop: Callable[..., NDArray[np.float64]] = njit(cache=True)(slide)
    return loop


def slide(
    spline: NDArray[np.float32],
    scale: float,
    cell: float,
    dt: float,
    path: NDArray[np.float64],
    sideways: NDArray[np.float64],
    load: NDArray[np.float64],
    start: tuple[float, float],
    heading: tuple[float, float],
    contact: tuple[float, float, float],
    grip: tuple[float, float, float, float],
    friction: tuple[float, float, float],
    bristles: tuple[float, float, float],
) -> NDArray[np.float64]:
    """Return the signals of a contactor that a hand drags over a surface, float64, shape (6, time), as `COLUMNS`.

    Normal to the surface m z'' + b (z' - u') + k (z - u) = 0 with u the height at the contactor while it presses; in
    the air only the load acts. Along and across, a mass on the grip of the hand is pushed by the slopes of the surface
    and, along, held by LuGre friction (Canudas de Wit, Olsson, Astrom, Lischinsky 1995) under the momentary normal
    force N: z' = v - sigma0 |v| z / g(v), F = sigma0 z + sigma1 z' + sigma2 v, g(v) = N (mu_c + (mu_s - mu_c) exp(-(v /
    v_s)^2)).

    Masses and springs are advanced by the trapezoidal rule, which damps nothing; the stiff bristle by the implicit
    Euler rule with |v| / g(v) of the previous step, which is stable at any step. Both are solved together: one division
    per direction and step.

    Parameters
    ----------
    spline : float32 array, shape (row, column)
        Coefficients of the cubic B-spline of the heights; periodic, a power of two each way.
    scale, cell : float, m
        Its unit, and its grid.
    dt : float, s
    path, sideways : float64 arrays, shape (time,), m
        Position of the hand along and across its heading.
    load : float64 array, shape (time,), N
        Normal force of the hand.
    start, heading : (x, y)
        Start of the stroke, m, and the unit vector along it.
    contact, grip : (mass kg, spring N/m, damper N s/m)
        Normal to the surface, and in it; the grip's fourth number is the share of the slopes' push that it takes.
    friction : (mu_c, mu_s, v_s in m/s)
    bristles : (sigma0 N/m, sigma1 N s/m, sigma2 N s/m)
    """
    n = len(path)
    out = np.empty((6, n))
    rows, columns = spline.shape
    m, k, b = contact
    mg, kg, bg, share = grip
    mu_c, mu_s, v_s = friction
    sigma0, sigma1, sigma2 = bristles
    wx, wy, gx, gy = np.empty(4), np.empty(4), np.empty(4), np.empty(4)

    # Begin in the middle of sliding: bristles bent, the grip stretched by the friction.
    v = (path[1] - path[0]) / dt if n > 1 else 0.0
    side = np.sign(v)
    bend = side * load[0] * mu_c / sigma0
    before = path[0] - dt * v
    s = before - (sigma0 * bend + sigma2 * v) / kg
    y = dy = u = z = w = 0.0
    for i in range(n):
        # The height and its slopes where the contactor is about to be.
        ahead = s + dt * v
        aside = sideways[i] + y
        px = (start[0] + heading[0] * ahead - heading[1] * aside) / cell
        py = (start[1] + heading[1] * ahead + heading[0] * aside) / cell
        ix, iy = int(np.floor(px)), int(np.floor(py))
        for t, w4, g4 in ((px - ix, wx, gx), (py - iy, wy, gy)):
            r = 1.0 - t
            w4[0], w4[3] = r * r * r / 6.0, t * t * t / 6.0
            w4[1] = 2.0 / 3.0 - t * t * (1.0 - t / 2.0)
            w4[2] = 2.0 / 3.0 - r * r * (1.0 - r / 2.0)
            g4[0], g4[3] = -r * r / 2.0, t * t / 2.0
            g4[1], g4[2] = t * (1.5 * t - 2.0), -r * (1.5 * r - 2.0)
        height = slope_x = slope_y = 0.0
        for a in range(4):
            line = (iy + a - 1) & (rows - 1)
            value = slope = 0.0
            for c in range(4):
                node = spline[line, (ix + c - 1) & (columns - 1)]
                value += wx[c] * node
                slope += gx[c] * node
            height += wy[a] * value
            slope_y += gy[a] * value
            slope_x += wy[a] * slope
        height *= scale
        along = share * scale * (slope_x * heading[0] + slope_y * heading[1]) / cell
        across = share * scale * (slope_y * heading[0] - slope_x * heading[1]) / cell
        if i == 0:
            u = z = height
            # It rides on the slope already: no jump of the heights' rate at the start.
            w = scale * (slope_x * heading[0] + slope_y * heading[1]) / cell * v

        # Normal: the mean force of the step, by how far and how fast spring and damper are pressed.
        rise = (height - u) / dt
        rest = 0.5 * k * (u + height - 2.0 * z - 0.5 * dt * w) + b * (rise - 0.5 * w)
        w_new = (m / dt * w + rest) / (m / dt + 0.25 * dt * k + 0.5 * b)
        press = rest - (0.25 * dt * k + 0.5 * b) * w_new
        if press < -load[i]:
            press = -load[i]
            w_new = w + dt * press / m
        out[2, i] = (w_new - w) / dt
        z += 0.5 * dt * (w + w_new)
        u, w = height, w_new
        force = load[i] + press
        out[4, i] = force

        # Along: friction is f0 + f1 v_new.
        g = max(force, 1e-6) * (mu_c + (mu_s - mu_c) * np.exp(-((v / v_s) ** 2)))
        keep = 1.0 / (1.0 + dt * sigma0 * abs(v) / g)
        f0 = sigma0 * keep * bend + sigma1 * (keep - 1.0) * bend / dt
        f1 = sigma0 * keep * dt + sigma1 * keep + sigma2
        speed = (path[i] - before) / dt
        pulled = 0.5 * kg * (before + path[i] - 2.0 * s - 0.5 * dt * v) + bg * (speed - 0.5 * v)
        v_new = (mg / dt * v + pulled - force * along - f0) / (mg / dt + 0.25 * dt * kg + 0.5 * bg + f1)
        out[0, i] = (v_new - v) / dt
        out[3, i] = f0 + f1 * v_new
        bend = keep * (bend + dt * v_new)
        s += 0.5 * dt * (v + v_new)
        v, before = v_new, path[i]
        out[5, i] = s

        # Across: the grip alone, pushed by the slope.
        held = -kg * (y + 0.25 * dt * dy) - 0.5 * bg * dy
        dy_new = (mg / dt * dy + held - force * across) / (mg / dt + 0.25 * dt * kg + 0.5 * bg)
        out[1, i] = (dy_new - dy) / dt
        y += 0.5 * dt * (dy + dy_new)
        dy = dy_new
    return out
