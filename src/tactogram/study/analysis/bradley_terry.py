"""Strengths of items from who was preferred to whom, with the error that differences between participants leave.

R. A. Bradley, M. E. Terry, Biometrika 39 (1952): P(i over j) = 1 / (1 + exp(s_j - s_i)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Numbers = NDArray[np.float64]
PRIOR_SD = 3.0
"""Of log strengths: keeps those of what always wins finite, and moves others little (a factor of 20 is one SD)."""
LEAST = 1e-6
"""Smaller standard errors of a difference are none: what rounding leaves."""


def bradley_terry(wins: ArrayLike, *, prior_sd: float = PRIOR_SD, tolerance: float = 1e-5) -> Numbers:
    """Return log strengths of items: the maximum of the likelihood with a weak normal prior.

    Parameters
    ----------
    wins : float array, shape (…, item, item)
        How often the row's was preferred to the column's.
    prior_sd : float
    tolerance : float
        Largest last step; the error that is left is of the order of its square.

    Returns
    -------
    float64 array, shape (…, item)
        Their mean is 0.
    """
    table = np.asarray(wins, np.float64)
    asked, won = table + np.swapaxes(table, -1, -2), table.sum(-1)
    strengths = np.zeros(table.shape[:-1])
    for _ in range(100):
        p = _preferred(strengths)
        gradient = won - (asked * p).sum(-1) - strengths / prior_sd**2
        step = np.linalg.solve(_bent(asked, p, 1 / prior_sd**2), gradient[..., None])[..., 0]
        # Concave: a bounded Newton step cannot run away.
        step *= np.minimum(1.0, 2.0 / np.maximum(np.abs(step).max(-1, keepdims=True), 1e-12))
        strengths = strengths + step
        if np.abs(step).max() < tolerance:
            break
    return np.asarray(strengths - strengths.mean(-1, keepdims=True))


def strengths_by_participant(tables: ArrayLike, *, prior_sd: float = PRIOR_SD) -> tuple[Numbers, Numbers]:
    """Return log strengths, and their covariance by participant.

    The covariance is that of the jackknife over participants, in one Newton step each: for the logit of a share this
    is that of L. A. Mancl and T. A. DeRouen (Biometrics 57, 2001). Answers of one participant may depend on each other
    as they like, and the next pair on the answers before.

    Parameters
    ----------
    tables : float array, shape (…, participant, item, item)
        Each participant's own: how often the row's was preferred to the column's. At least two participants.
    prior_sd : float

    Returns
    -------
    strengths : float64 array, shape (…, item)
        Their mean is 0.
    covariance : float64 array, shape (…, item, item)
    """
    own = np.asarray(tables, np.float64)
    people, items = own.shape[-3], own.shape[-1]
    strengths = bradley_terry(own.sum(-3), prior_sd=prior_sd)
    p = _preferred(strengths)[..., None, :, :]
    asked = own + np.swapaxes(own, -1, -2)
    pulls, bends = own.sum(-1) - (asked * p).sum(-1), _bent(asked, p, 0.0)
    rest = bends.sum(-3, keepdims=True) - bends + np.eye(items) / prior_sd**2
    left_out = np.linalg.solve(rest, pulls[..., None])[..., 0]
    left_out -= left_out.mean(-1, keepdims=True)
    covariance = np.einsum("...pi,...pj->...ij", left_out, left_out) * (people - 1) / people
    return strengths, covariance


def curvature(wins: Numbers, strengths: Numbers, *, prior_sd: float = PRIOR_SD) -> Numbers:
    """Return the negative second derivatives of what `bradley_terry` makes largest, shape (…, item, item)."""
    return _bent(wins + np.swapaxes(wins, -1, -2), _preferred(strengths), 1 / prior_sd**2)


def gap_errors(
    covariance: Numbers, curved: Numbers, first: NDArray[np.int64], second: NDArray[np.int64]
) -> tuple[Numbers, NDArray[np.bool_]]:
    """Return the standard error of differences of two strengths, and where all participants say the same of them.

    There the jackknife leaves none, however few they are, and it is that of independent answers.

    Parameters
    ----------
    covariance : float64 array, shape (…, item, item)
        By participant.
    curved : float64 array, shape (…, item, item)
        `curvature` of all answers.
    first, second : int64 array, shape (pair,)

    Returns
    -------
    errors : float64 array, shape (…, pair)
    alike : bool array, shape (…, pair)
    """
    variance = _of_gaps(covariance, first, second)
    alike = variance < LEAST**2
    if alike.any():
        alone = np.asarray(np.linalg.inv(curved), np.float64)
        variance = np.where(alike, _of_gaps(alone, first, second), variance)
    return np.sqrt(variance), alike


def _of_gaps(covariance: Numbers, first: NDArray[np.int64], second: NDArray[np.int64]) -> Numbers:
    own = np.diagonal(covariance, axis1=-2, axis2=-1)
    return np.asarray(own[..., first] + own[..., second] - 2 * covariance[..., first, second])


def _preferred(strengths: Numbers) -> Numbers:
    """Return how likely the row's is preferred to the column's, shape (…, item, item)."""
    worth = np.exp(strengths - strengths.max(-1, keepdims=True))
    return np.asarray(worth[..., :, None] / (worth[..., :, None] + worth[..., None, :]))


def _bent(asked: Numbers, p: Numbers, prior: float) -> Numbers:
    """Return negative second derivatives, shape (…, item, item); ``asked``: how often about row and column."""
    bent = asked * p * (p - 1)
    np.einsum("...ii->...i", bent)[...] += prior - bent.sum(-1)
    return np.asarray(bent)
