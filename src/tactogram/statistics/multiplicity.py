"""p-values corrected for multiple comparisons."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def holm(ps: ArrayLike) -> list[float]:
    """Return p with the step-down correction of S. Holm, Scand. J. Stat. 6 (1979), in their order.

    What statsmodels' ``multipletests`` returns; that collects garbage of the whole process at each call, which takes a
    tenth of a second where much is loaded, and was most of the time of an analysis.

    Parameters
    ----------
    ps : float array, shape (test,)
        From 0 to 1; may be empty.
    """
    given = np.asarray(ps, np.float64).ravel()
    order = np.argsort(given, kind="stable")
    stepped = given[order] * np.arange(len(given), 0, -1)
    corrected = np.empty_like(given)
    corrected[order] = np.minimum(np.maximum.accumulate(stepped), 1.0)
    return [float(p) for p in corrected]
