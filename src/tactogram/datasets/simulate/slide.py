"""Compiled loop of the contact simulation, one step per sample."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

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
