"""Tests and intervals of studies alone: shares of yes-or-no answers, d', and estimates from clustered answers.

E. B. Wilson, J. Am. Stat. Assoc. 22 (1927), and C. J. Clopper, E. S. Pearson, Biometrika 26 (1934), by scipy. d' by
N. A. Macmillan, C. D. Creelman, "Detection Theory: A User's Guide", 2nd ed. (2005), ch. 7 and 9. Equivalence by two
one-sided tests (D. J. Schuirmann, J. Pharmacokinet. Biopharm. 15, 1987), GEE and mixed models by statsmodels. What
evaluation has, too, is in `tactogram.statistics`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import optimize, special, stats
from threadpoolctl import threadpool_limits

from tactogram.errors import ParameterError

Numbers = NDArray[np.float64]
TAIL = (1 - 0.95) / 2
"""Probability on each side of an interval of 95 %, as a float: 0.025 would change last digits."""


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
def share_of(count: int, n: int) -> ShareEstimate:
    """Return a share of independent answers with its exact test against one half and its intervals."""
    if not 0 <= count <= n or n < 1:
        raise ParameterError(f"a share needs 0 <= count <= n and n >= 1, got {count} of {n}")
    test = stats.binomtest(count, n)

    def interval(method: str) -> tuple[float, float]:
        ends = test.proportion_ci(0.95, method)
        return float(ends.low), float(ends.high)

    return ShareEstimate(count, n, count / n, float(test.pvalue), interval("wilson"), interval("exact"))


@lru_cache(maxsize=1024)
def smallest_significant(n: int) -> int | None:
    """Return the smallest count above one half with a two-sided exact p below .05; None if there is none."""
    shown = np.flatnonzero(exact_ps(n) < 0.05)
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
    from statsmodels.stats.proportion import binom_tost

    _check_share(margin)
    return float(binom_tost(count, n, 0.5 - margin, 0.5 + margin)[0])


def share_equivalence_power(n: int, *, margin: float, alpha: float = 0.05) -> float:
    """Return how often `share_equivalence` shows that a share of one half lies within the margin.

    0 where no count of n can show it: the two rejection regions do not meet, for which statsmodels'
    ``power_binom_tost`` returns numbers below 0.
    """
    from statsmodels.stats.proportion import binom_tost_reject_interval

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


@dataclass(frozen=True)
class EffectEstimate:
    """Estimate with its interval and test; ``equivalence_p`` of two one-sided tests, None without a margin."""

    estimate: float
    low: float
    high: float
    statistic: float | None = None
    p: float | None = None
    note: str = ""
    equivalence_p: float | None = None


def pooled_share(
    hits: ArrayLike, participants: Sequence[Hashable], *, margin: float | None = None
) -> EffectEstimate:
    """Return the share of hits (1, else 0) with an interval of 95 % by participant, tested against one half.

    GEE with a binomial family, independence as working correlation, the covariance of L. A. Mancl and T. A. DeRouen
    (Biometrics 57, 2001), which few participants need, and t with participants - 1 degrees of freedom on the logit.
    With a margin also tests equivalence: share within 0.5 ± ``margin``. Raises `ParameterError` if there are fewer than
    two participants, or the lengths differ.
    """
    values = np.asarray(hits, np.float64)
    people = tuple(dict.fromkeys(participants))
    if values.ndim != 1 or len(values) != len(participants):
        raise ParameterError(
            f"hits and participants must be of one length, got {len(values)} and {len(participants)}"
        )
    if len(people) < 2:
        raise ParameterError(f"a share by participant needs two participants, got {len(people)}")
    if values.min() == values.max():
        return _unanimous(bool(values[0] > 0), len(people), margin)
    index_of = {name: number for number, name in enumerate(people)}
    logit, se, note = _logit(values, np.array([index_of[name] for name in participants]))
    df = len(people) - 1
    t = logit / se
    half = float(stats.t.isf(TAIL, df)) * se
    equal = None
    if margin is not None:
        below, above = special.logit(0.5 - margin), special.logit(0.5 + margin)
        equal = float(max(stats.t.sf((logit - below) / se, df), stats.t.sf((above - logit) / se, df)))
    low, high = special.expit(logit - half), special.expit(logit + half)
    p = float(2 * stats.t.sf(abs(t), df))
    return EffectEstimate(float(values.mean()), float(low), float(high), float(t), p, note, equal)


def _logit(values: Numbers, who: NDArray[np.int64]) -> tuple[float, float, str]:
    """Return the logit of the share, its standard error by participant, and a note."""
    from statsmodels.genmod.families import Binomial
    from statsmodels.genmod.generalized_estimating_equations import GEE

    order = np.argsort(who, kind="stable")
    with warnings.catch_warnings(), threadpool_limits(1):
        warnings.simplefilter("ignore")
        model = GEE(values[order], np.ones((len(values), 1)), groups=who[order], family=Binomial())
        fit = model.fit(cov_type="bias_reduced")
    se = float(fit.bse[0])
    share = float(values.mean())
    if se > 1e-9:
        return float(fit.params[0]), se, ""
    alone = float(1 / np.sqrt(len(values) * share * (1 - share)))
    return float(fit.params[0]), alone, "all participants have one share: error as of independent answers"


def _unanimous(hit: bool, people: int, margin: float | None) -> EffectEstimate:
    """Return the share where all answers are alike: each participant counts once, by Clopper-Pearson."""
    test = stats.binomtest(people if hit else 0, people)
    ends = test.proportion_ci(0.95, "exact")
    return EffectEstimate(
        float(hit),
        float(ends.low),
        float(ends.high),
        float("inf") if hit else float("-inf"),
        float(test.pvalue),
        "all answers were alike: each participant counts as one answer, by exact binomial",
        None if margin is None else 1.0,
    )


def mixed_difference(
    values: ArrayLike, second: ArrayLike, participants: Sequence[Hashable], items: Sequence[Hashable]
) -> EffectEstimate:
    """Return the mean difference of two conditions by a linear mixed model, fitted to the mean of each cell.

    Random intercepts of participants and items, and a random difference per participant, without which the interval
    would be of these participants only. ``second`` is true for answers of the condition from which the other is
    subtracted; all arguments have length (answer,).
    """
    import pandas as pd
    from statsmodels.regression.mixed_linear_model import MixedLM

    table = pd.DataFrame(
        {
            "value": np.asarray(values, np.float64),
            "x": np.asarray(second, np.float64),
            "person": [str(name) for name in participants],
            "item": [str(name) for name in items],
        }
    )
    cells = table.groupby(["person", "item", "x"], as_index=False)["value"].mean()
    cells["all"] = 1
    parts = {"person": "0 + C(person)", "slope": "0 + C(person):x"}
    if cells["item"].nunique() > 1:
        parts["item"] = "0 + C(item)"
    with warnings.catch_warnings(record=True) as caught, threadpool_limits(1):
        warnings.simplefilter("always")
        fit = MixedLM.from_formula("value ~ x", cells, groups="all", vc_formula=parts).fit(method=["lbfgs"])
    note = "" if fit.converged else "the fit did not converge"
    if not note and any("singular" in str(warning.message).lower() for warning in caught):
        note = "singular fit: some random effect is 0"
    low, high = map(float, fit.conf_int().loc["x"])
    estimate, t, p = (float(column["x"]) for column in (fit.params, fit.tvalues, fit.pvalues))
    return EffectEstimate(estimate, low, high, t, p, note)


def bootstrap_by_participant(
    table: ArrayLike,
    statistic: Callable[[Numbers], Numbers],
    *,
    rng: np.random.Generator,
    draws: int = 2000,
) -> tuple[Numbers, Numbers, Numbers]:
    """Return a statistic with the ends of its percentile interval of 95 % over participants drawn with replacement.

    ``table``, shape (participant, …), has a row per participant, drawn as a whole; ``statistic`` maps such a table to a
    number or an array. Of one participant the ends are NaN.
    """
    values = np.asarray(table, np.float64)
    estimate = np.asarray(statistic(values), np.float64)
    if len(values) == 1:
        missing = np.full(estimate.shape, np.nan)
        return estimate, missing, missing
    drawn = np.stack([statistic(values[rng.integers(0, len(values), len(values))]) for _ in range(draws)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a word that nobody of a draw answered
        low, high = np.nanquantile(drawn, [TAIL, 0.975], axis=0)
    return estimate, np.asarray(low), np.asarray(high)
