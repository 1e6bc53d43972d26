"""Many staircases of simulated participants at once: how well reversals find a threshold in so many trials."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import special

Numbers = NDArray[np.float64]
STEPS_DB = (8.0, 4.0, 2.0)


def simulated_thresholds(
    place: Numbers,
    trials: int,
    *,
    slope: float,
    rng: np.random.Generator,
    down: int = 3,
    start_db: float = 0.0,
    leave_out: int = 2,
) -> Numbers:
    """Return the mean of reversals of 1 up n down staircases with two alternatives, for every observer.

    Parameters
    ----------
    place : float64 array, any shape
        Middle of each simulated observer's logistic function, dB.
    trials : int
        Of each staircase.
    slope : float
        Of the function, per dB.
    rng : numpy Generator
    down : int
        Right answers in a row before the intensity falls.
    start_db : float
    leave_out : int
        First reversals that are not counted.

    Returns
    -------
    float64 array, shape of ``place``
        dB; the last intensity where there are too few reversals.
    """
    x = np.full(place.shape, start_db)
    run, heading, turned, counted = (np.zeros(place.shape, int) for _ in range(4))
    total = np.zeros(place.shape)
    for _ in range(trials):
        right = rng.random(place.shape) < 0.5 + 0.5 * special.expit(slope * (x - place))
        run = np.where(right, run + 1, 0)
        move = np.where(~right, 1, np.where(run >= down, -1, 0))
        reversal = (move != 0) & (heading != 0) & (move != heading)
        turned += reversal
        taken = reversal & (turned > leave_out)
        total += np.where(taken, x, 0.0)
        counted += taken
        x = x + move * np.asarray(STEPS_DB)[np.minimum(turned, len(STEPS_DB) - 1)]
        run = np.where(move != 0, 0, run)
        heading = np.where(move != 0, move, heading)
    return np.where(counted > 1, total / np.maximum(counted, 1), x)
