"""Weights of rated surfaces by how near their scores are to those asked: a library of a few dozen will do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.special import softmax

from tactogram.errors import ParameterError

WIDTH = 0.5
"""Of the kernel, as a share of the median distance of rated surfaces from their nearest neighbour in words."""


def word_weights(rated: NDArray[np.float64], scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a weight of each rated surface, float64, shape (surface,), by its distance in words; they sum to 1.

    The weights are those of kernel regression (Nadaraya 1964; Watson 1964) with a Gaussian: narrow, as surfaces of like
    scores can be unlike each other, and a mix of them like none.

    Parameters
    ----------
    rated : float64 array, shape (surface, word)
        Mean scores, 0 to 1; NaN where nobody gave any. Surfaces that lack one of the words asked weigh nothing.
    scores : float64 array, shape (word,)
        Those asked, 0 to 1; NaN if any will do.

    Raises
    ------
    ParameterError
        If no score is asked, or no surface was rated in all the words.
    """
    asked = np.isfinite(scores)
    whole = np.isfinite(rated[:, asked]).all(1)
    if not asked.any() or not whole.any():
        raise ParameterError("words must be at least one that a surface was rated in, got none")
    known = rated[np.ix_(whole, asked)]
    nearest = np.median(KDTree(known).query(known, k=2)[0][:, 1])
    width = max(WIDTH * float(nearest), np.finfo(float).eps)
    weights = np.zeros(len(rated))
    weights[whole] = softmax(-np.sum((known - scores[asked]) ** 2, axis=1) / (2 * width**2))
    return weights
