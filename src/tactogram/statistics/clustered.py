"""Estimates that know which answers came from one person: GEE, mixed models, bootstrap by participant."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy import special, stats
from threadpoolctl import threadpool_limits

from tactogram.errors import ParameterError

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class PooledShare:
    """A share over participants, with the interval that their differences leave.

    Parameters
    ----------
    share, low, high : float
    statistic, p : float
        t with ``participants - 1`` degrees of freedom, and its two-sided p against ``chance``.
    chance : float
    n, participants : int
    equivalence_p : float or None
        Of two one-sided tests within the margin; None where none was given.
    note : str
        Where the estimate is not the usual one, why.
    """

    share: float
    low: float
    high: float
    statistic: float
    p: float
    chance: float
    n: int
    participants: int
    equivalence_p: float | None = None
    note: str = ""


@dataclass(frozen=True)
class EffectEstimate:
    """A number with its interval.

    Parameters
    ----------
    estimate, low, high : float
    statistic, p : float or None
    note : str
    """

    estimate: float
    low: float
    high: float
    statistic: float | None = None
    p: float | None = None
    note: str = ""


def pooled_share(
    hits: ArrayLike,
    participants: Sequence[Hashable],
    *,
    chance: float = 0.5,
    margin: float | None = None,
    confidence: float = 0.95,
) -> PooledShare:
    """Return the share of hits with an interval by participant: GEE with a binomial family.

    Independence as working correlation, the covariance of L. A. Mancl and T. A. DeRouen (Biometrics 57, 2001), which
    few participants need, and t with participants - 1 degrees of freedom on the logit.

    Parameters
    ----------
    hits : array of 0 and 1, shape (answer,)
    participants : sequence, length (answer,)
    chance : float
    margin : float, optional
        For equivalence: share within ``chance`` ± ``margin``.
    confidence : float

    Raises
    ------
    ParameterError
        If there are fewer than two participants, or the two are not of one length.
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
        return _unanimous(int(values.sum() > 0) * len(people), len(people), len(values), chance, margin)
    place = {name: number for number, name in enumerate(people)}
    who = np.array([place[name] for name in participants])
    logit, se, note = _logit(values, who)
    df = len(people) - 1
    t = (logit - special.logit(chance)) / se
    half = float(stats.t.isf((1 - confidence) / 2, df)) * se
    equal = None
    if margin is not None:
        below, above = special.logit(chance - margin), special.logit(chance + margin)
        equal = float(max(stats.t.sf((logit - below) / se, df), stats.t.sf((above - logit) / se, df)))
    return PooledShare(
        float(values.mean()),
        float(special.expit(logit - half)),
        float(special.expit(logit + half)),
        float(t),
        float(2 * stats.t.sf(abs(t), df)),
        chance,
        len(values),
        len(people),
        equal,
        note,
    )


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


def _unanimous(ones: int, people: int, n: int, chance: float, margin: float | None) -> PooledShare:
    """Return the share where every answer was alike: each participant counts once, by Clopper-Pearson."""
    test = stats.binomtest(ones, people, chance)
    ends = test.proportion_ci(0.95, "exact")
    return PooledShare(
        ones / people,
        float(ends.low),
        float(ends.high),
        float("inf") if ones else float("-inf"),
        float(test.pvalue),
        chance,
        n,
        people,
        None if margin is None else 1.0,
        "all answers were alike: each participant counts as one answer, by exact binomial",
    )


def mixed_difference(
    values: ArrayLike, second: ArrayLike, participants: Sequence[Hashable], items: Sequence[Hashable]
) -> EffectEstimate:
    """Return the mean difference of two conditions by a linear mixed model, fitted to the mean of each cell.

    Random intercepts of participants and items, and a random difference per participant, without which the interval
    would be of these participants only.

    Parameters
    ----------
    values : float array, shape (answer,)
    second : bool array, shape (answer,)
        Which answers are of the condition from which the other is subtracted.
    participants, items : sequence, length (answer,)
    """
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
    with warnings.catch_warnings(record=True) as said, threadpool_limits(1):
        warnings.simplefilter("always")
        fit = MixedLM.from_formula("value ~ x", cells, groups="all", vc_formula=parts).fit(method=["lbfgs"])
    note = "" if fit.converged else "the fit did not converge"
    if not note and any("singular" in str(one.message).lower() for one in said):
        note = "singular fit: some random effect is 0"
    low, high = fit.conf_int().loc["x"]
    return EffectEstimate(
        float(fit.params["x"]),
        float(low),
        float(high),
        float(fit.tvalues["x"]),
        float(fit.pvalues["x"]),
        note,
    )


def bootstrap_by_participant(
    table: ArrayLike,
    of: Callable[[Numbers], Numbers],
    *,
    rng: np.random.Generator,
    draws: int = 2000,
    confidence: float = 0.95,
) -> tuple[Numbers, Numbers, Numbers]:
    """Return a statistic with its percentile interval over participants drawn with replacement.

    Parameters
    ----------
    table : float array, shape (participant, …)
        All that one participant answered is one row, and is drawn together.
    of : callable
        From such a table to a number or an array of them.
    rng : numpy Generator
    draws : int
    confidence : float

    Returns
    -------
    tuple of float64 array
        The statistic, and its lower and upper ends; of one participant the ends are NaN.

    Raises
    ------
    ParameterError
        If there is no participant, or ``draws`` is below 1.
    """
    values = np.asarray(table, np.float64)
    if not len(values) or draws < 1:
        raise ParameterError(f"a bootstrap needs a participant and a draw, got {len(values)} and {draws}")
    found = np.asarray(of(values), np.float64)
    if len(values) == 1:
        nothing = np.full(found.shape, np.nan)
        return found, nothing, nothing
    drawn = np.stack([of(values[rng.integers(0, len(values), len(values))]) for _ in range(draws)])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a word that nobody of a draw answered
        low, high = np.nanquantile(drawn, [(1 - confidence) / 2, (1 + confidence) / 2], axis=0)
    return found, np.asarray(low), np.asarray(high)
