"""Mean, standard error and interval of answers, and p-values corrected for multiple comparisons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class GroupSummary:
    """Summary of the values that are not missing: ``sd`` with n - 1, ``se`` = sd / sqrt(n), t interval of the mean.

    Of a single value ``sd``, ``se`` and the interval are NaN.
    """

    n: int
    mean: float
    sd: float
    se: float
    low: float
    high: float


def summary(values: ArrayLike) -> GroupSummary:
    """Return mean, spread and t interval of 95 % of an array without its NaN; `ParameterError` if it is empty."""
    present = np.asarray(values, np.float64).ravel()
    present = present[~np.isnan(present)]
    if not present.size:
        raise ParameterError("a summary needs a value, got none")
    mean = float(present.mean())
    if present.size == 1:
        return GroupSummary(1, mean, np.nan, np.nan, np.nan, np.nan)
    sd = float(present.std(ddof=1))
    se = sd / float(np.sqrt(present.size))
    half = float(stats.t.isf((1 - 0.95) / 2, present.size - 1)) * se
    return GroupSummary(present.size, mean, sd, se, mean - half, mean + half)


def nan_mean(
    values: ArrayLike, axis: int | tuple[int, ...], *, keepdims: bool = False
) -> NDArray[np.float64]:
    """Return means without NaN, and NaN for slices without values, of which ``np.nanmean`` would warn."""
    answers = np.asarray(values, np.float64)
    present = ~np.isnan(answers)
    total, count = (x.sum(axis, keepdims=keepdims) for x in (np.where(present, answers, 0), present))
    return np.asarray(np.divide(total, count, out=np.full(np.shape(total), np.nan), where=count > 0))


def holm(ps: ArrayLike) -> list[float]:
    """Return p with the step-down correction of S. Holm, Scand. J. Stat. 6 (1979), in their order; shape (test,).

    As statsmodels' ``multipletests``, which collects garbage at each call: a tenth of a second in a large process, and
    most of the time of an analysis.
    """
    corrected: list[float] = holm_rows(np.ravel(ps)).tolist()
    return corrected


def holm_rows(ps: ArrayLike) -> NDArray[np.float64]:
    """Return p of many families of tests, each corrected as by `holm`; shape (…, test)."""
    raw = np.asarray(ps, np.float64)
    order = np.argsort(raw, axis=-1, kind="stable")
    stepped = np.take_along_axis(raw, order, -1) * np.arange(raw.shape[-1], 0, -1)
    corrected = np.empty_like(raw)
    np.put_along_axis(corrected, order, np.minimum(np.maximum.accumulate(stepped, -1), 1.0), -1)
    return corrected


def pooled(windows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the probabilities of a recording: the mean of its windows' log probabilities, made to sum to 1.

    From shape (window, class) to (class,). In the geometric mean, a window that excludes a class counts more than an
    undecided one; it has fewer errors on recordings than the arithmetic mean (linear and logarithmic opinion pools,
    Genest and Zidek 1986).
    """
    log = np.log(np.maximum(windows, 1e-12)).mean(axis=0)
    share = np.exp(log - log.max())
    probabilities: NDArray[np.float64] = share / share.sum()
    return probabilities
