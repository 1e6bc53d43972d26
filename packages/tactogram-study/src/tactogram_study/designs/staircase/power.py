"""Power of staircases: many simulated observers at once, with thresholds by reversals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import special

from tactogram_study.power.methods import Means, StudyBatch

if TYPE_CHECKING:
    from tactogram_study.designs.staircase.design import Staircase

Numbers = NDArray[np.float64]
STEPS_DB = (8.0, 4.0, 2.0)
BELOW_START_DB = 20.0
"""Middle of a typical observer's function in the tables, below the start."""


class Staircases(Means):
    """Paired differences of two thresholds by reversals; ``threshold_error_db`` is the error of one."""

    def gaps(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        first = rng.normal(-BELOW_START_DB, 4.0, batch.shape)
        gaps = rng.normal(truth, batch.assumed.person_sd, first.shape)
        both = np.stack([first, first + gaps], -1)
        found = simulated_thresholds(both, batch.trials, slope=batch.assumed.trial_sd, rng=rng)
        return found[..., 1] - found[..., 0], {"threshold_error_db": float((found - both).std())}


def simulated_thresholds(
    place: Numbers,
    trials: int,
    *,
    slope: float,
    rng: np.random.Generator,
) -> Numbers:
    """Return the mean of reversals of 1 up 3 down staircases with two alternatives, for each simulated observer, dB.

    ``place`` is the middle of each observer's logistic function, dB above the start. Without the first two reversals;
    the last intensity where there are too few.
    """
    x = np.zeros(place.shape)
    run, heading, turned, counted = (np.zeros(place.shape, int) for _ in range(4))
    total = np.zeros(place.shape)
    for _ in range(trials):
        right = rng.random(place.shape) < 0.5 + 0.5 * special.expit(slope * (x - place))
        run = np.where(right, run + 1, 0)
        move = np.where(~right, 1, np.where(run >= 3, -1, 0))
        reversal = (move != 0) & (heading != 0) & (move != heading)
        turned += reversal
        taken = reversal & (turned > 2)
        total += np.where(taken, x, 0.0)
        counted += taken
        x = x + move * np.asarray(STEPS_DB)[np.minimum(turned, len(STEPS_DB) - 1)]
        run = np.where(move != 0, 0, run)
        heading = np.where(move != 0, move, heading)
    return np.where(counted > 1, total / np.maximum(counted, 1), x)


def typical_trials(design: Staircase, *, slope: float = 0.5) -> int:
    """Return the median number of trials of a study's staircase over 200 simulated observers.

    ``slope`` is that of their logistic function, per dB.
    """
    rng = np.random.default_rng(0)
    middle, trials = design.start_db - BELOW_START_DB, []
    for _ in range(200):
        track = design.start()
        while not design.ended(track):
            right = rng.random() < 0.5 + 0.5 * special.expit(slope * (track.intensity - middle))
            track = design.after(track, correct=bool(right))
        trials.append(track.trials)
    return int(np.median(trials))
