"""Monotonicity of a mixing ladder against chance, and its midpoint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression
from scipy.stats import t as student

Array = NDArray[np.float64]

SIGNIFICANCE = 0.05
DRAWS = 999
ROUNDING = 1e-9
"""Differences of position below this are rounding errors."""
FIGURES = (
    "resolution",
    "monotone_p",
    "tau",
    "tau_low",
    "tau_high",
    "half_weight",
    "half_low",
    "half_high",
)


def order_of(
    position: Array,
    members: Sequence[Array],
    weights: Array,
    *,
    end_error: Array,
    rng: np.random.Generator,
) -> dict[str, float]:
    """Return the test of whether ``position`` rises with ``weights``, shape (step,), and the weight at one half.

    The result holds `FIGURES`, as in `tactogram.evaluation.mixing.placement.MixingLadder`; NaN where ``position`` is.

    Parameters
    ----------
    position : float64 array, shape (step,)
        Mean of each step's ``members``; NaN where it is undefined.
    members : sequence of float64 arrays, shape (signal,)
        Positions of the step's signals; their variance is pooled over steps.
    end_error : float64 array, shape (2,)
        Standard errors of the ends at 0 and 1, which move all steps together.
    """
    if np.isnan(position).any():
        return dict.fromkeys(FIGURES, np.nan)
    counts = np.array([len(part) for part in members])
    freedom = int((counts - 1).sum())
    pooled = sum(float(part.var(ddof=1)) * (len(part) - 1) for part in members) / freedom
    seen = _drop(position, counts)
    if pooled > ROUNDING**2:
        same = rng.standard_normal((DRAWS, len(counts))) / np.sqrt(counts)
        scale = rng.chisquare(freedom, DRAWS) / freedom
        drops = np.array([_drop(row, counts) for row in same]) / scale
        p = float((1 + np.count_nonzero(drops >= seen / pooled - ROUNDING)) / (1 + DRAWS))
    else:
        p = 1.0 if seen <= ROUNDING**2 else 0.0
    own = np.sqrt(pooled / counts) * rng.standard_t(freedom, (DRAWS, len(counts)))
    tau = _tau(position + own)
    # The noise of the ends moves all steps together: it changes where they lie, not their order.
    ends = rng.standard_normal((DRAWS, 2)) * end_error
    moved = position + own - ends[:, :1] * (1 - position) - ends[:, 1:] * position
    halves = np.array([_half(weights, row, counts) for row in moved])
    tails = (SIGNIFICANCE / 2, 1 - SIGNIFICANCE / 2)
    tau_low, tau_high = np.quantile(tau, tails)
    half_low, half_high = np.quantile(halves, tails, method="inverted_cdf")
    reach = student.ppf(tails[1], freedom) * np.sqrt(2 * pooled / counts.mean())
    half = _half(weights, position, counts)
    figures = (reach, p, _tau(position[None])[0], tau_low, tau_high, half, half_low, half_high)
    return {name: float(value) for name, value in zip(FIGURES, figures, strict=True)}


def _drop(position: Array, counts: NDArray[np.int_]) -> float:
    """Return the squared residual of the least increasing curve through ``position``, weighted by counts."""
    fit = isotonic_regression(position, weights=counts).x
    return float(counts @ (position - fit) ** 2)


def _half(weights: Array, position: Array, counts: NDArray[np.int_]) -> float:
    """Return the weight at which the increasing curve crosses one half; infinite if it stays below."""
    fit = isotonic_regression(position, weights=counts).x
    above = int(np.searchsorted(fit, 0.5))
    if above == len(fit):
        return np.inf
    if above == 0:
        return float(weights[0])
    share = (0.5 - fit[above - 1]) / (fit[above] - fit[above - 1])
    return float(weights[above - 1] + share * (weights[above] - weights[above - 1]))


def _tau(position: Array) -> Array:
    """Return Kendall's tau of each row with the order of its columns, float64, shape (row,)."""
    one, other = np.triu_indices(position.shape[1], k=1)
    tau: Array = np.sign(position[:, other] - position[:, one]).mean(axis=1)
    return tau
