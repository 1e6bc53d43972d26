"""Inter-rater reliability: Krippendorff's alpha and intraclass correlations.

K. Krippendorff, "Computing Krippendorff's Alpha-Reliability", 2011 (NLTK's form of it). P. E. Shrout, J. L. Fleiss,
"Intraclass Correlations: Uses in Assessing Rater Reliability", Psychological Bulletin 86 (1979), with the mean squares
of statsmodels' analysis of variance.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.extras import imported

Level = Literal["nominal", "ordinal", "interval"]
LEVELS = ("nominal", "ordinal", "interval")


@dataclass(frozen=True)
class IntraclassCorrelation:
    """Result of `intraclass_correlation`.

    Parameters
    ----------
    single : float
        ICC(2,1): agreement of one rater with another.
    average : float
        ICC(2,k): agreement of the mean of these raters with that of others.
    items, raters : int
        Complete ones, from which it was computed.
    left_out_items, left_out_raters : int
        Incomplete ones.
    """

    single: float
    average: float
    items: int
    raters: int
    left_out_items: int
    left_out_raters: int


def krippendorff_alpha(scores: ArrayLike, *, level: Level) -> float | None:
    """Return Krippendorff's alpha: 1 where all agree, 0 where they agree as by chance.

    Raises `ParameterError` if ``scores`` is no table, or ``level`` is unknown.

    Parameters
    ----------
    scores : float array, shape (item, rater)
        NaN where missing; items with fewer than two scores are ignored.
    level : {"nominal", "ordinal", "interval"}
        Meaning of the difference of two scores.

    Returns
    -------
    float or None
        None if no item has two scores, or all scores are alike.
    """
    table = _table(scores)
    if level not in LEVELS:
        raise ParameterError.one_of("level", LEVELS, level)
    present = ~np.isnan(table)
    present &= present.sum(1, keepdims=True) >= 2
    values, codes = np.unique(table[present], return_inverse=True)
    if len(values) < 2:
        return None
    distance = _distances(values, np.bincount(codes), level)
    items, raters = np.nonzero(present)
    task = alpha_library().AnnotationTask(
        data=list(zip(raters.tolist(), items.tolist(), codes.tolist(), strict=True)),
        distance=lambda a, b: float(distance[a, b]),
    )
    return float(task.alpha())


def alpha_library() -> ModuleType:
    """Return the module that computes alpha: a whole toolkit, which takes seconds; errors as of `imported`."""
    return imported("nltk.metrics.agreement", extra="statistics", what="Krippendorff's alpha")


def intraclass_correlation(scores: ArrayLike) -> IntraclassCorrelation | None:
    """Return ICC(2,1) and ICC(2,k): raters and items both drawn at random, absolute agreement.

    Raises `ParameterError` if ``scores`` is no table.

    Parameters
    ----------
    scores : float array, shape (item, rater)
        NaN where missing. The analysis needs a complete table: the rater or item that lacks the largest share of scores
        is left out until nothing is missing.

    Returns
    -------
    IntraclassCorrelation or None
        None if fewer than two items or raters are complete, or all scores are alike.
    """
    table = _table(scores)
    whole = _complete(table)
    items, raters = whole.shape
    if items < 2 or raters < 2 or np.ptp(whole) == 0:
        return None
    by_item, by_rater = whole.mean(1, keepdims=True), whole.mean(0, keepdims=True)
    between = float(raters * np.var(by_item, ddof=1))
    rater = float(items * np.var(by_rater, ddof=1))
    residuals = whole - by_item - by_rater + whole.mean()
    rest = float((residuals**2).sum() / ((items - 1) * (raters - 1)))
    shared = (rater - rest) / items
    return IntraclassCorrelation(
        (between - rest) / (between + (raters - 1) * rest + raters * shared),
        (between - rest) / (between + shared),
        items,
        raters,
        table.shape[0] - items,
        table.shape[1] - raters,
    )


def _table(scores: ArrayLike) -> NDArray[np.float64]:
    table = np.asarray(scores, np.float64)
    if table.ndim != 2 or np.isinf(table).any():
        raise ParameterError.must("scores", f"be finite or NaN, shape (item, rater), got shape {table.shape}")
    return table


def _distances(values: NDArray[np.float64], counts: NDArray[np.int64], level: Level) -> NDArray[np.float64]:
    """Return the squared difference of every two values, shape (value, value)."""
    if level == "nominal":
        return 1.0 - np.eye(len(values))
    # Of ranks that count every score between two: sum of n_g from c to k, less half of n_c and n_k.
    scores = np.cumsum(counts) - counts / 2 if level == "ordinal" else values
    squared: NDArray[np.float64] = (scores[:, None] - scores[None, :]) ** 2
    return squared


def _complete(table: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the table without the items and raters that lack the most scores, until nothing is missing."""
    while table.size and np.isnan(table).any():
        by_item, by_rater = np.isnan(table).mean(1), np.isnan(table).mean(0)
        if by_item.max() >= by_rater.max():
            table = np.delete(table, by_item.argmax(), 0)
        else:
            table = np.delete(table, by_rater.argmax(), 1)
    return table
