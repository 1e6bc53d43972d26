"""Two one-sided tests: whether a difference lies within a margin that was given before.

D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15 (1987). What the usual test does not show is not shown to be absent;
this can show it, if there are answers enough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import stats
from statsmodels.stats.proportion import binom_tost, binom_tost_reject_interval

from tactogram.errors import ParameterError
from tactogram.statistics.summary import summary


@dataclass(frozen=True)
class Equivalence:
    """Result of two one-sided tests.

    Parameters
    ----------
    margin : float
        Half the width of what counts as equal, in the unit of what was measured.
    p : float
        The larger of the two.
    low, high : float
        Interval of 1 - 2 alpha: where it lies within the margin, p is below alpha.
    """

    margin: float
    p: float
    low: float
    high: float


def share_equivalence(
    count: int, n: int, *, margin: float, chance: float = 0.5, alpha: float = 0.05
) -> Equivalence:
    """Return whether a share of independent answers lies within ``chance`` ± ``margin``, by exact binomial tests.

    Raises
    ------
    ParameterError
        If ``chance`` ± ``margin`` does not lie between 0 and 1, or ``count`` not from 0 to ``n``.
    """
    _check_share(margin, chance)
    if not 0 <= count <= n or n < 1:
        raise ParameterError(f"a share needs 0 <= count <= n and n >= 1, got {count} of {n}")
    p = float(binom_tost(count, n, chance - margin, chance + margin)[0])
    ends = stats.binomtest(count, n, chance).proportion_ci(1 - 2 * alpha, "exact")
    return Equivalence(margin, p, float(ends.low), float(ends.high))


def share_equivalence_power(
    n: int, *, margin: float, truth: float = 0.5, chance: float = 0.5, alpha: float = 0.05
) -> float:
    """Return how often `share_equivalence` shows that a share of ``truth`` lies within the margin.

    0 where no count of n can show it: the two rejection regions do not meet, of which statsmodels'
    ``power_binom_tost`` gives numbers below 0.
    """
    _check_share(margin, chance)
    low, high = (int(end) for end in binom_tost_reject_interval(chance - margin, chance + margin, n, alpha))
    if low > high:
        return 0.0
    return float(stats.binom.cdf(high, n, truth) - stats.binom.cdf(low - 1, n, truth))


def paired_equivalence(differences: ArrayLike, *, margin: float, alpha: float = 0.05) -> Equivalence:
    """Return whether the mean of independent differences lies within ± ``margin``, by Student's t.

    Parameters
    ----------
    differences : float array, shape (participant,)
        One per participant, in the unit of ``margin``.
    margin : float
        > 0.
    alpha : float

    Raises
    ------
    ParameterError
        If ``margin`` is not > 0, or there are fewer than two differences.
    """
    if not margin > 0:
        raise ParameterError(f"margin must be > 0, got {margin:g}")
    values = np.asarray(differences, np.float64).ravel()
    if len(values) < 2 or not np.isfinite(values).all():
        raise ParameterError(f"two finite differences are needed, got {int(np.isfinite(values).sum())}")
    found = summary(values, confidence=1 - 2 * alpha)
    if found.se == 0:
        return Equivalence(margin, 0.0 if abs(found.mean) < margin else 1.0, found.low, found.high)
    p = stats.t.sf((margin - abs(found.mean)) / found.se, len(values) - 1)
    return Equivalence(margin, float(p), found.low, found.high)


def _check_share(margin: float, chance: float) -> None:
    if not (margin > 0 and chance - margin > 0 and chance + margin < 1):
        raise ParameterError(
            f"margin of a share must be > 0 and less than {min(chance, 1 - chance):g} "
            f"(0.1 means ten points of a hundred), got {margin:g}"
        )
