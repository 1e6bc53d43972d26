"""Strengths of items from preferences, with errors by participant.

R. A. Bradley, M. E. Terry, Biometrika 39 (1952): P(i over j) = 1 / (1 + exp(s_j - s_i)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Numbers = NDArray[np.float64]
PRIOR_SD = 3.0
"""Of log strengths: keeps those of items that always win finite, and moves others little (one SD is a factor of 20)."""
LEAST = 1e-6
"""Smaller standard errors of a difference count as 0: they are rounding."""


def bradley_terry(wins: ArrayLike, *, prior_sd: float = PRIOR_SD, tolerance: float = 1e-5) -> Numbers:
    """Return log strengths of items, with mean 0: the maximum of the likelihood with a weak normal prior.

    ``wins``, shape (…, item, item), counts how often the row's item was preferred to the column's. Newton's method
    stops at steps below ``tolerance``; the remaining error is of the order of its square.
    """
    table = np.asarray(wins, np.float64)
    counts, won = table + np.swapaxes(table, -1, -2), table.sum(-1)
    strengths = np.zeros(table.shape[:-1])
    for _ in range(100):
        p = _preferred(strengths)
        gradient = won - (counts * p).sum(-1) - strengths / prior_sd**2
        step = np.linalg.solve(_negative_hessian(counts, p, 1 / prior_sd**2), gradient[..., None])[..., 0]
        # Concave: a bounded Newton step cannot run away.
        step *= np.minimum(1.0, 2.0 / np.maximum(np.abs(step).max(-1, keepdims=True), 1e-12))
        strengths = strengths + step
        if np.abs(step).max() < tolerance:
            break
    return np.asarray(strengths - strengths.mean(-1, keepdims=True))


def strengths_by_participant(tables: ArrayLike, *, prior_sd: float = PRIOR_SD) -> tuple[Numbers, Numbers]:
    """Return log strengths, shape (…, item), and their covariance by participant, shape (…, item, item).

    The covariance is that of the jackknife over participants, in one Newton step each: for the logit of a share this is
    that of L. A. Mancl and T. A. DeRouen (Biometrics 57, 2001). Answers of one participant may depend on each other in
    any way, and the next pair on the previous answers.

    ``tables``, shape (…, participant, item, item), count how often each of at least two participants preferred the
    row's item to the column's.
    """
    wins = np.asarray(tables, np.float64)
    people, items = wins.shape[-3], wins.shape[-1]
    strengths = bradley_terry(wins.sum(-3), prior_sd=prior_sd)
    p = _preferred(strengths)[..., None, :, :]
    counts = wins + np.swapaxes(wins, -1, -2)
    gradients, hessians = wins.sum(-1) - (counts * p).sum(-1), _negative_hessian(counts, p, 0.0)
    rest = hessians.sum(-3, keepdims=True) - hessians + np.eye(items) / prior_sd**2
    left_out = np.linalg.solve(rest, gradients[..., None])[..., 0]
    left_out -= left_out.mean(-1, keepdims=True)
    covariance = np.einsum("...pi,...pj->...ij", left_out, left_out) * (people - 1) / people
    return strengths, covariance


def curvature(wins: Numbers, strengths: Numbers, *, prior_sd: float = PRIOR_SD) -> Numbers:
    """Return the negative second derivatives of the maximum of `bradley_terry`, shape (…, item, item)."""
    return _negative_hessian(wins + np.swapaxes(wins, -1, -2), _preferred(strengths), 1 / prior_sd**2)


def gap_errors(
    covariance: Numbers, curved: Numbers, first: NDArray[np.int64], second: NDArray[np.int64]
) -> tuple[Numbers, NDArray[np.bool_]]:
    """Return the standard error of differences of two strengths, and whether all participants agree on them.

    Where they agree the jackknife has no error, however few they are; the error is then that of independent answers,
    from the `curvature` of all of them. The results have shape (…, pair).
    """
    variance = _of_gaps(covariance, first, second)
    alike = variance < LEAST**2
    if alike.any():
        alone = np.asarray(np.linalg.inv(curved), np.float64)
        variance = np.where(alike, _of_gaps(alone, first, second), variance)
    return np.sqrt(variance), alike


def _of_gaps(covariance: Numbers, first: NDArray[np.int64], second: NDArray[np.int64]) -> Numbers:
    variances = np.diagonal(covariance, axis1=-2, axis2=-1)
    return np.asarray(variances[..., first] + variances[..., second] - 2 * covariance[..., first, second])


def _preferred(strengths: Numbers) -> Numbers:
    """Return the probability that the row's item is preferred to the column's, shape (…, item, item)."""
    worth = np.exp(strengths - strengths.max(-1, keepdims=True))
    return np.asarray(worth[..., :, None] / (worth[..., :, None] + worth[..., None, :]))


def _negative_hessian(counts: Numbers, p: Numbers, prior: float) -> Numbers:
    """Return negative second derivatives, shape (…, item, item), from the number of comparisons of each pair."""
    hessian = counts * p * (p - 1)
    np.einsum("...ii->...i", hessian)[...] += prior - hessian.sum(-1)
    return np.asarray(hessian)
