"""Paired differences: equivalence, Wilcoxon's exact p with ties, and the pseudomedian with its interval.

J. L. Hodges, E. L. Lehmann, Ann. Math. Stat. 34 (1963): median of the means of every two differences. D. J. Schuirmann,
J. Pharmacokinet. Biopharm. 15 (1987): two one-sided tests show that a difference is within a margin set beforehand. A
difference that the usual test does not show may still exist.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from tactogram.errors import ParameterError
from tactogram.statistics.groups import summary

EXACT_UP_TO = 100
"""Largest number of differences with an exact distribution of the rank sum; above, it is taken as normal."""


def pseudomedian(differences: ArrayLike) -> tuple[float, float | None, float | None]:
    """Return the Hodges-Lehmann estimate and the interval of 95 % that inverts the signed-rank test.

    Of finite differences, shape (participant,); with fewer than 6 the ends are None.
    """
    d = np.asarray(differences, np.float64).ravel()
    first, second = np.triu_indices(len(d))
    means = np.sort((d[first] + d[second]) / 2)
    out = _outside(len(d), (1 - 0.95) / 2)
    if out < 1:
        return float(np.median(means)), None, None
    return float(np.median(means)), float(means[out - 1]), float(means[-out])


def signed_rank_p(differences: ArrayLike) -> float:
    """Return the two-sided p of Wilcoxon's signed ranks; differences of 0 are dropped, as Wilcoxon did.

    Of finite differences, shape (participant,). Exact, ties included, up to `EXACT_UP_TO` of them; scipy tries every
    sign of up to 13, which takes seconds.
    """
    d = np.asarray(differences, np.float64).ravel()
    d = d[d != 0]
    if not len(d):
        return 1.0
    if len(d) > EXACT_UP_TO:
        return float(stats.wilcoxon(d).pvalue)
    doubled = np.rint(2 * stats.rankdata(np.abs(d))).astype(int)  # mid ranks are halves
    likely = _rank_sums(doubled.tolist())
    got = int(doubled[d > 0].sum())
    return float(min(1.0, 2 * min(likely[: got + 1].sum(), likely[got:].sum())))


def _outside(n: int, tail: float) -> int:
    """Return the position, from 1, of the sorted mean that ends the interval; 0 if there is none."""
    if n > EXACT_UP_TO:
        middle, sd = n * (n + 1) / 4, np.sqrt(n * (n + 1) * (2 * n + 1) / 24)
        return int(max(0.0, np.floor(middle - stats.norm.isf(tail) * sd)))
    # The interval holds where the rank sum exceeds the largest w of P(W <= w) <= tail; its end is mean w + 1.
    within = np.flatnonzero(np.cumsum(_rank_sums(range(1, n + 1))) <= tail)
    return int(within[-1]) + 1 if len(within) else 0


def _rank_sums(ranks: Iterable[int]) -> NDArray[np.float64]:
    """Return the probability of each sum of integer ranks with random signs: shape (sum of ranks + 1,)."""
    listed = list(ranks)
    likely = np.zeros(sum(listed) + 1)
    likely[0] = 1.0
    for rank in listed:
        shifted = np.zeros_like(likely)
        shifted[rank:] = likely[: len(likely) - rank]
        likely = (likely + shifted) / 2
    return likely


def paired_equivalence(differences: ArrayLike, *, margin: float) -> float:
    """Return the p that the mean of differences, shape (participant,), lies within ± ``margin``, by Student's t."""
    if not margin > 0:
        raise ParameterError(f"margin must be > 0, got {margin:g}")
    found = summary(differences)
    if found.se == 0:
        return 0.0 if abs(found.mean) < margin else 1.0
    return float(stats.t.sf((margin - abs(found.mean)) / found.se, found.n - 1))
