"""How a hand strokes: speed, place and force over time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

LENGTH_MM = 100.0
"""Length of a back-and-forth stroke: the plates of Saga et al. are "about 100 mm in length"."""
TURN = 0.15
"""Share of a stroke that is spent turning, at each end."""


@dataclass(frozen=True)
class Stroke:
    """A stroke sampled at ``rate``: all arrays float64, shape (time,).

    Parameters
    ----------
    rate : float, Hz
    path_mm : along the stroke, mm
    speed_mm_s : signed, mm/s
    force_n : normal force of the hand, N, > 0
    """

    rate: float
    path_mm: NDArray[np.float64]
    speed_mm_s: NDArray[np.float64]
    force_n: NDArray[np.float64]


def stroke(
    rng: np.random.Generator,
    *,
    seconds: float,
    rate: float,
    speed_mm_s: float,
    force_n: float,
    back_and_forth: bool,
    unsteadiness: float = 0.06,
) -> Stroke:
    """Return a stroke at an "almost constant speed" (Saga et al., Sec. II-C).

    Parameters
    ----------
    rng : numpy Generator
    seconds, rate : float, s and Hz
    speed_mm_s, force_n : float
        Nominal; ``unsteadiness`` is how much they wander, as a share (force twice as much).
    back_and_forth : bool
        Over `LENGTH_MM` and back with smooth turns, or in one direction with a smooth start and end.
    """
    n = round(seconds * rate)
    t = np.arange(n) / rate
    speed = speed_mm_s * (1 + unsteadiness * _slow(rng, n, rate, 2.0))
    if back_and_forth:
        # Turns are slower: the nominal speed is that of the middle.
        half = LENGTH_MM / (1 - TURN) / speed_mm_s
        phase = (t / half + rng.random()) % 2
        within = phase % 1
        edge = np.minimum(within, 1 - within) / TURN
        profile = np.sin(np.pi / 2 * np.clip(edge, 0, 1)) * np.where(phase < 1, 1.0, -1.0)
    else:
        ramp = min(0.15, seconds / 4)
        edge = np.minimum(t, t[-1] - t) / ramp
        profile = np.sin(np.pi / 2 * np.clip(edge, 0, 1)) ** 2
    velocity = speed * profile
    path = np.cumsum(velocity) / rate
    force = force_n * np.exp(2 * unsteadiness * _slow(rng, n, rate, 3.0))
    return Stroke(rate, path, velocity, force)


def tremor(rng: np.random.Generator, n: int, rate: float, degrees: float) -> NDArray[np.float64]:
    """Return slowly wandering angles, radians, float64, shape (3, time): the hand is never still."""
    angles: NDArray[np.float64] = np.deg2rad(degrees) * np.stack([_slow(rng, n, rate, 1.5) for _ in range(3)])
    return angles


def _slow(rng: np.random.Generator, n: int, rate: float, cutoff_hz: float) -> NDArray[np.float64]:
    """Return noise of rms about 1 below ``cutoff_hz``, made at a low rate and interpolated."""
    low = 8 * cutoff_hz
    count = int(n / rate * low) + 8
    points = gaussian_filter1d(rng.standard_normal(count), 1.5)
    points /= np.sqrt(1 / (2 * 1.5 * np.sqrt(np.pi)))
    noise: NDArray[np.float64] = np.interp(np.arange(n) / rate * low, np.arange(count), points)
    return noise
