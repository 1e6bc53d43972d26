"""Two one-sided tests: whether a difference lies within a margin that was set beforehand.

D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15 (1987). A difference that the usual test does not show may still exist;
with enough answers, this test shows that it is small.
"""

from __future__ import annotations

from numpy.typing import ArrayLike
from scipy import stats
from statsmodels.stats.proportion import binom_tost, binom_tost_reject_interval

from tactogram.errors import ParameterError
from tactogram.statistics.groups import summary


def share_equivalence(count: int, n: int, *, margin: float) -> float:
    """Return the p that a share of independent answers lies within 0.5 ± ``margin``, by exact binomial tests."""
    _check_share(margin)
    return float(binom_tost(count, n, 0.5 - margin, 0.5 + margin)[0])


def share_equivalence_power(n: int, *, margin: float, alpha: float = 0.05) -> float:
    """Return how often `share_equivalence` shows that a share of one half lies within the margin.

    0 where no count of n can show it: the two rejection regions do not meet, for which statsmodels'
    ``power_binom_tost`` returns numbers below 0.
    """
    _check_share(margin)
    low, high = (int(end) for end in binom_tost_reject_interval(0.5 - margin, 0.5 + margin, n, alpha))
    if low > high:
        return 0.0
    return float(stats.binom.cdf(high, n, 0.5) - stats.binom.cdf(low - 1, n, 0.5))


def paired_equivalence(differences: ArrayLike, *, margin: float) -> float:
    """Return the p that the mean of differences, shape (participant,), lies within ± ``margin``, by Student's t."""
    if not margin > 0:
        raise ParameterError(f"margin must be > 0, got {margin:g}")
    found = summary(differences)
    if found.se == 0:
        return 0.0 if abs(found.mean) < margin else 1.0
    return float(stats.t.sf((margin - abs(found.mean)) / found.se, found.n - 1))


def _check_share(margin: float) -> None:
    if not 0 < margin < 0.5:
        raise ParameterError(
            f"margin of a share must be > 0 and less than 0.5 (0.1 means ten points of a hundred), got {margin:g}"
        )
