"""Accuracies with their confidence intervals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from tactogram.errors import ParameterError


class Accuracy(NamedTuple):
    """A share of correct answers, 0..1, with Wilson's 95 % interval."""

    accuracy: float
    low: float
    high: float


def wilson(share: float, trials: int) -> Accuracy:
    """Return ``share`` with Wilson's 95 % score interval.

    With z = 1.96 and n trials: (p + z^2/2n +- z sqrt(p (1-p)/n + z^2/4n^2)) / (1 + z^2/n).

    ``share`` is in 0..1, and ``share * trials`` need not be a whole number; ``trials`` counts *independent* answers.

    References
    ----------
    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212.
    """
    if trials < 1 or not 0 <= share <= 1:
        raise ParameterError(
            f"share must be in 0..1 and trials >= 1 for an interval, got {share} and {trials}"
        )
    z = float(norm.ppf(0.975))
    middle = share + z**2 / (2 * trials)
    half = z * float(np.sqrt(share * (1 - share) / trials + z**2 / (4 * trials**2)))
    scale = 1 + z**2 / trials
    low = 0.0 if share == 0 else (middle - half) / scale
    high = 1.0 if share == 1 else (middle + half) / scale
    return Accuracy(share, low, high)
