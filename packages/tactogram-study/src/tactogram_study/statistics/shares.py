"""Shares of yes-or-no answers: exact tests, equivalence and intervals, and d' of shares correct.

E. B. Wilson, J. Am. Stat. Assoc. 22 (1927), and C. J. Clopper, E. S. Pearson, Biometrika 26 (1934), by scipy. d' by
N. A. Macmillan, C. D. Creelman, "Detection Theory: A User's Guide", 2nd ed. (2005), ch. 7 and 9. Equivalence by two
one-sided tests (D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15, 1987), by statsmodels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, special, stats
from statsmodels.stats.proportion import binom_tost, binom_tost_reject_interval

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class ShareEstimate:
    """Share among independent answers, its two-sided exact p against one half, and two intervals."""

    count: int
    n: int
    share: float
    p: float
    wilson: tuple[float, float]
    clopper_pearson: tuple[float, float]


@lru_cache(maxsize=4096)
def share_of(count: int, n: int, *, confidence: float = 0.95) -> ShareEstimate:
    """Return a share of independent answers with its exact test against one half and its intervals."""
    if not 0 <= count <= n or n < 1:
        raise ParameterError(f"a share needs 0 <= count <= n and n >= 1, got {count} of {n}")
    test = stats.binomtest(count, n)

    def interval(method: str) -> tuple[float, float]:
        ends = test.proportion_ci(confidence, method)
        return float(ends.low), float(ends.high)

    return ShareEstimate(count, n, count / n, float(test.pvalue), interval("wilson"), interval("exact"))


@lru_cache(maxsize=1024)
def smallest_significant(n: int, *, alpha: float = 0.05) -> int | None:
    """Return the smallest count above one half with a two-sided exact p below ``alpha``; None if there is none."""
    shown = np.flatnonzero(exact_ps(n) < alpha)
    above = shown[shown > n * 0.5]
    return int(above[0]) if len(above) else None


def exact_ps(n: int, *, chance: float = 0.5) -> NDArray[np.float64]:
    """Return p of the two-sided exact binomial test for every count from 0 to n; float64, shape (n + 1,).

    As scipy's ``binomtest``, for all counts at once.
    """
    likely = stats.binom.pmf(np.arange(n + 1), n, chance)
    # Two-sided as scipy's: all counts that are no likelier under chance than the observed one.
    order = np.argsort(likely, kind="stable")
    ends = np.searchsorted(likely[order], likely * (1 + 1e-7), side="right")
    return np.asarray(np.minimum(np.cumsum(likely[order])[ends - 1], 1.0))


def d_prime_2afc(share: float) -> float:
    """Return d' of a share correct with two intervals or places: sqrt(2) z(share); infinite at 0 and 1."""
    return float(np.sqrt(2) * stats.norm.ppf(share))


def d_prime_abx(share: float) -> float:
    """Return d' of a share correct in ABX, by independent observations; 0 at chance or below.

    share = F(d'/sqrt 2) F(d'/2) + F(-d'/sqrt 2) F(-d'/2), F the normal distribution (Macmillan, Creelman, ch. 9).
    """
    if share <= 0.5:
        return 0.0
    if share >= 1:
        return float("inf")
    return float(optimize.brentq(lambda d: abx_share(d) - share, 0, 40))


def abx_share(d_prime: float) -> float:
    """Return the share correct in ABX of an observer with that d'; the inverse of `d_prime_abx`."""
    f = special.ndtr
    a, b = d_prime / np.sqrt(2), d_prime / 2
    return float(f(a) * f(b) + f(-a) * f(-b))


def corrected(count: int, n: int) -> float:
    """Return (count + 1/2) / (n + 1): a share that is never 0 or 1 (M. J. Hautus, Behav. Res. Methods 27, 1995)."""
    return (count + 0.5) / (n + 1)


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


def _check_share(margin: float) -> None:
    if not 0 < margin < 0.5:
        raise ParameterError(
            f"margin of a share must be > 0 and less than 0.5 (0.1 means ten points of a hundred), got {margin:g}"
        )
