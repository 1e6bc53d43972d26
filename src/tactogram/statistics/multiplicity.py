"""p-values corrected for multiple comparisons."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def holm(ps: ArrayLike) -> list[float]:
    """Return p with the step-down correction of S. Holm, Scand. J. Stat. 6 (1979), in their order; shape (test,).

    As statsmodels' ``multipletests``, which collects garbage at each call: a tenth of a second in a large process, and
    most of the time of an analysis.
    """
    raw = np.asarray(ps, np.float64).ravel()
    order = np.argsort(raw, kind="stable")
    stepped = raw[order] * np.arange(len(raw), 0, -1)
    corrected = np.empty_like(raw)
    corrected[order] = np.minimum(np.maximum.accumulate(stepped), 1.0)
    return [float(p) for p in corrected]
