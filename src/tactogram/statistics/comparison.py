"""Tests between conditions: as printed in the publications, and as repeated answers require.

Answers of one person are not independent. `steel_dwass` and `student_t` take every value as independent, as the
publications did with n = 2,400; `paired_t` and `friedman_wilcoxon` compare the same people, `mann_whitney` the
means of different people.

J. L. Hodges, E. L. Lehmann, Ann. Math. Stat. 34 (1963): median of the means of every two differences. D. J. Schuirmann,
J. Pharmacokinet. Biopharm. 15 (1987): two one-sided tests show that a difference is within a margin set beforehand. A
difference that the usual test does not show may still exist.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from tactogram.errors import ParameterError
from tactogram.extras import imported
from tactogram.statistics.groups import GroupSummary, holm, summary

INDEPENDENT = "takes every value as independent, which repeated answers of one person are not"
Numbers = NDArray[np.float64]
PERMUTED_UP_TO = 13
"""Number of people up to which scipy tries every sign of tied differences; `signed_rank_p` is 1,000 times faster."""
EXACT_UP_TO = 100
"""Largest number of differences with an exact distribution of the rank sum; above, it is taken as normal."""


@dataclass(frozen=True)
class PairComparison:
    """Comparison of two conditions.

    Parameters
    ----------
    difference : float
        Mean of ``first`` minus mean of ``second``.
    statistic : float
        Above 0 where ``first`` is higher, except for Wilcoxon's W, which has no sign.
    p : float
        Two-sided, with `Comparison.correction`.
    """

    first: str
    second: str
    difference: float
    statistic: float
    p: float


@dataclass(frozen=True)
class Comparison:
    """Result of a test between conditions.

    Parameters
    ----------
    groups : mapping from str to GroupSummary
        Of each condition.
    pairs : tuple of PairComparison
        Every two conditions, in the given order.
    correction : str
        Correction of the pairs' ``p`` for multiple comparisons.
    overall : tuple of (float, float), optional
        Statistic and p over all conditions at once.
    left_out : int
        People without a value in some condition.
    caveat : str
        Assumption of the test that the data may not meet, or "".
    """

    test: str
    groups: Mapping[str, GroupSummary]
    pairs: tuple[PairComparison, ...]
    correction: str
    overall: tuple[float, float] | None = None
    left_out: int = 0
    caveat: str = ""

    def pair(self, first: str, second: str) -> PairComparison:
        """Return the comparison of two conditions, in either order; raise `ParameterError` if there is none."""
        for pair in self.pairs:
            if {pair.first, pair.second} == {first, second}:
                return pair
        raise ParameterError(f"two of {', '.join(self.groups)} must be named, got {first!r} and {second!r}")

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return asdict(self)


def steel_dwass(groups: Mapping[str, ArrayLike]) -> Comparison:
    """Return the Steel-Dwass test (Dwass, Steel, Critchlow, Fligner) between every two groups, with ties.

    ``statistic`` is t as in R. G. D. Steel, Technometrics 2 (1960): the rank sum of the two groups in normal form, with
    mid ranks; p is that of the studentised range of t * sqrt(2).

    Raises `ParameterError` if a group is too small or has a value that is not finite.

    Parameters
    ----------
    groups : mapping from str to float array, shape (value,)
        At least two, each of at least two values.
    """
    # Imports its plotting, which takes seconds.
    scikit_posthocs = imported("scikit_posthocs", extra="statistics", what="Steel-Dwass tests")

    samples = _groups(groups)
    with np.errstate(invalid="ignore"):  # two groups of one value: NaN, replaced below
        table = scikit_posthocs.posthoc_dscf(list(samples.values())).to_numpy()
    row_of = {name: number for number, name in enumerate(samples)}

    def compared(first: str, second: str) -> tuple[float, float]:
        p = float(table[row_of[first], row_of[second]])
        return _rank_z(samples[first], samples[second]), 1.0 if np.isnan(p) else p

    pairs = _pairs(samples, compared, "none")
    return Comparison("Steel-Dwass", _summaries(samples), pairs, "Steel-Dwass", caveat=INDEPENDENT)


def student_t(groups: Mapping[str, ArrayLike]) -> Comparison:
    """Return Student's t-test between every two groups: equal variances and no correction, as published.

    Parameters, of shape (value,), and errors as of `steel_dwass`.
    """
    return _independent("Student's t", groups, stats.ttest_ind, "none", INDEPENDENT)


def mann_whitney(groups: Mapping[str, ArrayLike]) -> Comparison:
    """Return the Mann-Whitney test between every two groups of different people, with Holm's correction.

    ``statistic`` is the rank sum in normal form. Parameters, of shape (subject,), one value per person, and errors as
    of `steel_dwass`.
    """

    def compared(a: Numbers, b: Numbers) -> tuple[float, float]:
        return _rank_z(a, b), float(stats.mannwhitneyu(a, b, alternative="two-sided").pvalue)

    return _independent("Mann-Whitney", groups, compared, "holm")


def paired_t(conditions: Mapping[str, ArrayLike]) -> Comparison:
    """Return the paired t-test between every two conditions that the same people answered, with Holm's correction.

    Raises `ParameterError` if there are fewer than two conditions or complete people, or they are not of one length.

    Parameters
    ----------
    conditions : mapping from str to float array, shape (subject,)
        One value per person, in the same order; people with a missing value (NaN) are left out.
    """
    samples, left_out = _complete(conditions)

    def compared(first: str, second: str) -> tuple[float, float]:
        if np.array_equal(samples[first], samples[second]):
            return 0.0, 1.0
        with _spreadless():
            result = stats.ttest_rel(samples[first], samples[second])
        return float(result.statistic), float(result.pvalue)

    pairs = _pairs(samples, compared, "holm")
    return Comparison("paired t", _summaries(samples), pairs, "holm", left_out=left_out)


def friedman_wilcoxon(conditions: Mapping[str, ArrayLike]) -> Comparison:
    """Return Friedman's test over all conditions, and Wilcoxon's signed ranks between every two (Holm).

    Raises `ParameterError` as `paired_t`.

    Parameters
    ----------
    conditions : mapping from str to float array, shape (subject,)
        As in `paired_t`; ``overall`` needs three.
    """
    samples, left_out = _complete(conditions)
    overall = None
    if len(samples) >= 3:
        same = all(np.array_equal(values, next(iter(samples.values()))) for values in samples.values())
        friedman = (0.0, 1.0) if same else stats.friedmanchisquare(*samples.values())
        overall = (float(friedman[0]), float(friedman[1]))

    def compared(first: str, second: str) -> tuple[float, float]:
        if np.array_equal(samples[first], samples[second]):
            return 0.0, 1.0
        apart = samples[first] - samples[second]
        if len(apart) <= PERMUTED_UP_TO:
            ranks = stats.rankdata(np.abs(apart[apart != 0]))
            up = float(ranks[apart[apart != 0] > 0].sum())
            return min(up, float(ranks.sum()) - up), signed_rank_p(apart)
        result = stats.wilcoxon(apart)
        return float(result.statistic), float(result.pvalue)

    pairs = _pairs(samples, compared, "holm")
    test = "Friedman, Wilcoxon signed ranks"
    return Comparison(test, _summaries(samples), pairs, "holm", overall, left_out)


def _independent(
    test: str,
    groups: Mapping[str, ArrayLike],
    compare: Callable[[Numbers, Numbers], Any],
    correction: str,
    caveat: str = "",
) -> Comparison:
    samples = _groups(groups)

    def compared(first: str, second: str) -> tuple[float, float]:
        if np.ptp(np.concatenate([samples[first], samples[second]])) == 0:
            return 0.0, 1.0
        with _spreadless():
            statistic, p = compare(samples[first], samples[second])
        return float(statistic), float(p)

    pairs = _pairs(samples, compared, correction)
    return Comparison(test, _summaries(samples), pairs, correction, caveat=caveat)


def _pairs(
    samples: Mapping[str, Numbers],
    compare: Callable[[str, str], tuple[float, float]],
    correction: str,
) -> tuple[PairComparison, ...]:
    names = list(combinations(samples, 2))
    results = [compare(first, second) for first, second in names]
    ps = [p for _, p in results]
    if correction == "holm":
        ps = holm(ps)
    return tuple(
        PairComparison(first, second, float(samples[first].mean() - samples[second].mean()), statistic, p)
        for (first, second), (statistic, _), p in zip(names, results, ps, strict=True)
    )


@contextmanager
def _spreadless() -> Iterator[None]:
    """Silence scipy's warnings about values without spread: their t is very large or infinite, as it should be."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        yield


def _rank_z(a: Numbers, b: Numbers) -> float:
    """Return the rank sum of ``a`` among both, in normal form and corrected for ties; 0 if all are tied."""
    ties = float(stats.tiecorrect(stats.rankdata(np.concatenate([a, b]))))
    return 0.0 if ties == 0 else float(stats.ranksums(a, b).statistic / np.sqrt(ties))


def _summaries(samples: Mapping[str, Numbers]) -> dict[str, GroupSummary]:
    return {name: summary(values) for name, values in samples.items()}


def _groups(groups: Mapping[str, ArrayLike]) -> dict[str, Numbers]:
    if len(groups) < 2:
        raise ParameterError(f"a comparison needs two groups, got {', '.join(groups) or 'none'}")
    samples = {name: np.asarray(values, np.float64).ravel() for name, values in groups.items()}
    for name, values in samples.items():
        if len(values) < 2:
            raise ParameterError(f"group {name}: must have two values, got {len(values)}")
        if not np.isfinite(values).all():
            raise ParameterError(f"group {name}: values must be finite; leave missing answers out first")
    return samples


def _complete(conditions: Mapping[str, ArrayLike]) -> tuple[dict[str, Numbers], int]:
    """Return the conditions of the people with a value in each, and the number of the others."""
    if len(conditions) < 2:
        raise ParameterError(f"a comparison needs two conditions, got {', '.join(conditions) or 'none'}")
    samples = {name: np.asarray(values, np.float64).ravel() for name, values in conditions.items()}
    if len({len(values) for values in samples.values()}) > 1:
        sizes = ", ".join(f"{name} {len(values)}" for name, values in samples.items())
        raise ParameterError(f"every person must be in every condition, got {sizes} values")
    table = np.stack(list(samples.values()))
    full = ~np.isnan(table).any(0)
    if np.isinf(table).any() or full.sum() < 2:
        raise ParameterError(
            f"two people must have a finite value in every condition, got {int(full.sum())} of {table.shape[1]}"
        )
    return {name: values[full] for name, values in samples.items()}, int((~full).sum())


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
    """Return the p that the mean of differences, shape (participant,), lies within ± ``margin``, by Student's t.

    Raises `ParameterError` if the margin is not positive.
    """
    if not margin > 0:
        raise ParameterError.must("margin", "be > 0", margin)
    result = summary(differences)
    if result.se == 0:
        return 0.0 if abs(result.mean) < margin else 1.0
    return float(stats.t.sf((margin - abs(result.mean)) / result.se, result.n - 1))
