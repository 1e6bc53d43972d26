"""Weights of rated surfaces that scores of words call for, in closed form: a library of a few dozen will do.

Surfaces of like scores can differ widely, and the mean of a tone and a noise is rated as neither. So the surface rated
nearest is kept, and moved along a regression by what its scores lack.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError

PENALTY = 0.1
"""Of the ridge regression, per rated surface and word, for scores of unit variance."""
LEAST_SPREAD = 1e-3
"""Least standard deviation that scores are divided by."""


def word_weights(rated: NDArray[np.float64], scores: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a weight of each rated surface, float64, shape (surface,); they sum to 1, and some are negative.

    The mix of surfaces by these weights is the surface rated nearest, plus the difference between what a ridge
    regression of surfaces on words predicts for the scores asked and for its own.

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
    spread = np.maximum(known.std(0), LEAST_SPREAD)
    nearest = int(np.sum((known - scores[asked]) ** 2, axis=1).argmin())
    x, lacks = (known - known.mean(0)) / spread, (scores[asked] - known[nearest]) / spread
    weights = np.zeros(len(rated))
    weights[whole] = x @ np.linalg.solve(x.T @ x + PENALTY * x.size * np.eye(x.shape[1]), lacks)
    weights[np.flatnonzero(whole)[nearest]] += 1
    return weights
