"""Strengths of items from who was preferred to whom, with the error that differences between participants leave.

R. A. Bradley, M. E. Terry, Biometrika 39 (1952): P(i over j) = 1 / (1 + exp(s_j - s_i)).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

Numbers = NDArray[np.float64]
PRIOR_SD = 3.0
"""Of log strengths: keeps those of what always wins finite, and moves others little (a factor of 20 is one SD)."""


def bradley_terry(wins: ArrayLike, *, prior_sd: float = PRIOR_SD) -> Numbers:
    """Return log strengths of items: the maximum of the likelihood with a weak normal prior.

    Parameters
    ----------
    wins : float array, shape (…, item, item)
        How often the row's was preferred to the column's.
    prior_sd : float

    Returns
    -------
    float64 array, shape (…, item)
        Their mean is 0.
    """
    table = np.asarray(wins, np.float64)
    strengths = np.zeros(table.shape[:-1])
    for _ in range(100):
        gradient = _gradient(table, strengths) - strengths / prior_sd**2
        curved = _curvature(table, strengths) + np.eye(table.shape[-1]) / prior_sd**2
        step = np.linalg.solve(curved, gradient[..., None])[..., 0]
        # Concave: a bounded Newton step cannot run away.
        step *= np.minimum(1.0, 2.0 / np.maximum(np.abs(step).max(-1, keepdims=True), 1e-12))
        strengths = strengths + step
        if np.abs(step).max() < 1e-10:
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
    every = np.broadcast_to(strengths[..., None, :], own.shape[:-1])
    pulls, bends = _gradient(own, every), _curvature(own, every)
    rest = bends.sum(-3, keepdims=True) - bends + np.eye(items) / prior_sd**2
    left_out = np.linalg.solve(rest, pulls[..., None])[..., 0]
    left_out -= left_out.mean(-1, keepdims=True)
    covariance = np.einsum("...pi,...pj->...ij", left_out, left_out) * (people - 1) / people
    return strengths, covariance


def _preferred(strengths: Numbers) -> Numbers:
    return np.asarray(special.expit(strengths[..., :, None] - strengths[..., None, :]))


def _gradient(wins: Numbers, strengths: Numbers) -> Numbers:
    """Return the slope of the log likelihood, shape (…, item)."""
    losing = np.swapaxes(_preferred(strengths), -1, -2) * wins
    return np.asarray(losing.sum(-1) - losing.sum(-2))


def _curvature(wins: Numbers, strengths: Numbers) -> Numbers:
    """Return the negative second derivatives of the log likelihood, shape (…, item, item)."""
    p = _preferred(strengths)
    weight = (wins + np.swapaxes(wins, -1, -2)) * p * np.swapaxes(p, -1, -2)
    return np.asarray(weight.sum(-1)[..., None] * np.eye(wins.shape[-1]) - weight)
