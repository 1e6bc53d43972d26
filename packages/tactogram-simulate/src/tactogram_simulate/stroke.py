"""Stroke kinematics: position, speed and force of a hand over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

LENGTH_MM = 80.0
"""Length of a pass: the plates of Saga et al. are "70-100 mm length and 100-130 mm width" (Fig. 4)."""
TURN_M_S2 = 10.0
"""Mean acceleration of a turning hand: from 400 mm/s to 400 mm/s the other way in 80 ms. Our assumption."""
UNSTEADINESS = 0.05
"""Relative variation of the speed, rms; the force varies twice as much. 0 is a machine."""

_AHEAD_S = 0.1


@dataclass(frozen=True)
class RecordingTask:
    """One recording to simulate; small, so that processes can exchange it."""

    set_name: str
    seed: int
    surface: int
    contactor: str
    speed_mm_s: float
    take: int
    seconds: float
    rate: float
    force_n: float | None = None
    """Mean normal force; by default about the usual one of the contactor."""
    own_image: bool = True
    """Whether it has the one photograph of its surface; false if the set has several of each."""


@dataclass(frozen=True)
class Stroke:
    """A stroke sampled at ``rate``: all arrays float64, shape (time,).

    ``path_mm`` and ``sideways_mm`` are the position of the hand along and across the stroke, ``force_n`` its normal
    force, > 0.
    """

    rate: float
    path_mm: NDArray[np.float64]
    sideways_mm: NDArray[np.float64]
    force_n: NDArray[np.float64]


def stroke(
    rng: np.random.Generator,
    *,
    seconds: float,
    rate: float,
    speed_mm_s: float,
    force_n: float,
    back_and_forth: bool,
    unsteadiness: float = UNSTEADINESS,
) -> Stroke:
    """Return a stroke at an "almost constant speed" (Saga et al., Sec. II-C).

    It goes back and forth over `LENGTH_MM`, or in one direction from rest to rest; speed and force are nominal.
    """
    n = round(seconds * rate)
    t = np.arange(n) / rate
    path = _there_and_back if back_and_forth else _one_way
    wander = unsteadiness / (2 * np.pi * 1.0)
    # Time itself is warped, by at most `_AHEAD_S`: the speed varies without drift of the position.
    warped = t + np.clip(wander * slow_noise(rng, n, rate, 2.0), -_AHEAD_S, _AHEAD_S)
    position = path(rng, seconds, speed_mm_s, unsteadiness)(warped)
    sideways = 25 * unsteadiness * slow_noise(rng, n, rate, 0.5)
    force = force_n * np.exp(2 * unsteadiness * slow_noise(rng, n, rate, 3.0))
    return Stroke(rate, position, sideways, force)


def slow_noise(rng: np.random.Generator, n: int, rate: float, below_hz: float) -> NDArray[np.float64]:
    """Return smooth Gaussian noise of rms about 1 without content above ``below_hz``, float64, shape (time,)."""
    seconds = n / rate
    knots = int(seconds * 4 * below_hz) + 8
    points = gaussian_filter1d(rng.standard_normal(knots + 8), 1.0, mode="constant")[4:-4]
    points *= np.sqrt(2 * np.sqrt(np.pi))
    grid = scipy.interpolate.CubicSpline(np.arange(knots) / (4 * below_hz), points)
    return np.asarray(grid(np.arange(n) / rate))


def _one_way(
    rng: np.random.Generator, seconds: float, speed: float, unsteadiness: float
) -> scipy.interpolate.BPoly:
    """Return the position over time, mm: speed up, slide, slow down."""
    turn = min(0.15, seconds / 4)
    ramp = speed * turn / 2
    far = 2 * ramp + speed * (seconds - 2 * turn)
    return scipy.interpolate.BPoly.from_derivatives(
        [-_AHEAD_S, 0, turn, seconds - turn, seconds, seconds + _AHEAD_S],
        [[0, 0, 0], [0, 0, 0], [ramp, speed, 0], [far - ramp, speed, 0], [far, 0, 0], [far, 0, 0]],
    )


def _there_and_back(
    rng: np.random.Generator, seconds: float, speed: float, unsteadiness: float
) -> scipy.interpolate.BPoly:
    """Return the position over time, mm: straight passes with minimum-jerk turns.

    Fifth-order polynomials through position, speed and acceleration have minimum jerk (Flash & Hogan 1985). Each pass
    has its own speed and end.
    """
    times: list[float] = []
    states: list[list[float]] = []
    t, side = -_AHEAD_S - 2 * LENGTH_MM / speed * rng.random(), 1.0
    fastest = speed * (1 + 3 * unsteadiness)
    turn = 2 * fastest / (1e3 * TURN_M_S2)
    reach = LENGTH_MM / 2 - turn * speed / 4
    position = -reach
    while not times or times[-1] < seconds + _AHEAD_S:
        v = speed * (1 + unsteadiness * np.clip(rng.standard_normal(), -2, 2))
        end = side * reach + 40 * unsteadiness * np.clip(rng.standard_normal(), -2, 2)
        times += [t, t + max(abs(end - position), 1.0) / v]
        states += [[position, side * v, 0], [end, side * v, 0]]
        t, position, side = times[-1] + turn, end, -side
    return scipy.interpolate.BPoly.from_derivatives(times, states)
