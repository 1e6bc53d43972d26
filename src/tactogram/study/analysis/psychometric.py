"""Trials of a staircase by intensity, and its threshold by reversals.

H. Levitt, "Transformed up-down methods in psychoacoustics", J. Acoust. Soc. Am. 49 (1971).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import DataError, ParameterError


def count_by_level(
    intensity: ArrayLike, correct: ArrayLike, *, needed_by: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the distinct intensities, their numbers of trials, and of right answers; of arrays of shape (trial,).

    Raises `ParameterError` for invalid arrays; `DataError`, with ``needed_by`` as subject, if there are fewer than two
    intensities, or all answers are alike.
    """
    x, y = np.asarray(intensity, np.float64), np.asarray(correct, np.float64)
    if x.ndim != 1 or x.shape != y.shape or not np.isfinite(x).all():
        raise ParameterError(
            f"intensity and correct must be finite, of one length, got {x.shape} and {y.shape}"
        )
    levels, place = np.unique(x, return_inverse=True)
    n = np.bincount(place).astype(np.float64)
    k = np.bincount(place, y).astype(np.float64)
    if len(levels) < 2 or k.sum() in (0, n.sum()):
        raise DataError(
            f"{needed_by} needs two intensities and both right and wrong answers, "
            f"got {len(levels)} intensities and {int(k.sum())} of {int(n.sum())} right"
        )
    return levels, n, k


def reversal_threshold(intensity: ArrayLike, reversal: Sequence[bool], *, leave_out: int = 2) -> float | None:
    """Return the mean intensity of a staircase's reversals, without the first ones; None if none is left.

    The first ``leave_out`` still depend on the starting intensity. If an odd number is left, one more is dropped, so
    that peaks and valleys count alike. Both arrays have shape (trial,).
    """
    turned = np.asarray(intensity, np.float64)[np.asarray(reversal, bool)][leave_out:]
    turned = turned[len(turned) % 2 :]
    return float(turned.mean()) if len(turned) else None
