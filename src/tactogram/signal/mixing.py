"""Shares of models in a mix, and the symmetric root of a covariance."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError

Array = NDArray[np.float64]


def checked_weights(weights: ArrayLike, count: int) -> Array:
    """Return the weights of ``count`` >= 1 models, float64; `ParameterError` if one is negative or all are 0."""
    w = np.asarray(weights, np.float64)
    if not count or w.shape != (count,) or not (np.isfinite(w).all() and (w >= 0).all() and w.any()):
        raise ParameterError(f"weights must be {count} numbers >= 0, not all 0; got {w.tolist()}")
    return w


def symmetric_root(covariance: Array) -> Array:
    """Return the symmetric square root, which also exists for a singular matrix and changes smoothly."""
    values, vectors = np.linalg.eigh(covariance)
    root: Array = (vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T
    return root
