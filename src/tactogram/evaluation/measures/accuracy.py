"""A share of right answers with its confidence interval."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from tactogram.errors import ParameterError


class Accuracy(NamedTuple):
    """A share of right answers, 0..1, and Wilson's 95 % interval around it."""

    accuracy: float
    low: float
    high: float


def wilson(share: float, trials: int) -> Accuracy:
    """Return ``share`` with Wilson's 95 % score interval.

    With z = 1.96 and n trials: (p + z^2/2n +- z sqrt(p (1-p)/n + z^2/4n^2)) / (1 + z^2/n).

    Parameters
    ----------
    share : float
        0..1; need not be a whole number of trials.
    trials : int
        How many *independent* answers it is the mean of.

    Raises
    ------
    ParameterError
        If there is no trial, or ``share`` is not a share.

    References
    ----------
    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212.
    """
    if trials < 1 or not 0 <= share <= 1:
        raise ParameterError(
            f"an interval needs a share in 0..1 of at least 1 trial, got {share} of {trials}"
        )
    z = float(norm.ppf(0.975))
    middle = share + z**2 / (2 * trials)
    half = z * float(np.sqrt(share * (1 - share) / trials + z**2 / (4 * trials**2)))
    scale = 1 + z**2 / trials
    low = 0.0 if share == 0 else (middle - half) / scale
    high = 1.0 if share == 1 else (middle + half) / scale
    return Accuracy(share, low, high)
