"""Confidence intervals of accuracies and of means."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm, t

from tactogram.errors import ParameterError

FEWEST = 3
"""An interval over fewer values is meaningless."""


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
        raise ParameterError.must(
            "share", f"be in 0..1 and trials >= 1 for an interval, got {share} and {trials}"
        )
    z = float(norm.ppf(0.975))
    middle = share + z**2 / (2 * trials)
    half = z * float(np.sqrt(share * (1 - share) / trials + z**2 / (4 * trials**2)))
    scale = 1 + z**2 / trials
    low = 0.0 if share == 0 else (middle - half) / scale
    high = 1.0 if share == 1 else (middle + half) / scale
    return Accuracy(share, low, high)


def mean_interval(
    values: NDArray[np.float64], *, least: float = -np.inf, most: float = np.inf
) -> tuple[float, float] | None:
    """Return Student's 95 % interval of a mean, within what is possible; None for fewer than three values.

    Parameters
    ----------
    values : float array, shape (n,) or (n, m)
        Independent values, such as one of each material. With two axes rows and columns are drawn independently, such
        as unknown and known materials; the margins of the two axes' means then add in quadrature (Zou & Donner 2008).
    least, most : float
        Smallest and largest value that the mean can have.

    References
    ----------
    G. Y. Zou and A. Donner, Stat. Med. 27 (2008) 1693-1702.
    """
    if min(values.shape) < FEWEST:
        return None
    means = [values] if values.ndim == 1 else [values.mean(1), values.mean(0)]
    margin, middle = np.hypot.reduce([margin_of(mean) for mean in means]), values.mean()
    return max(least, float(middle - margin)), min(most, float(middle + margin))


def margin_of(values: NDArray[np.float64]) -> float:
    """Return half the width of Student's 95 % interval of the mean of two or more values, shape (n,)."""
    count = len(values)
    return float(t.ppf(0.975, count - 1) * np.std(values, ddof=1) / np.sqrt(count))
