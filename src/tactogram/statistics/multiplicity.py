"""p-values corrected for multiple comparisons."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def holm(ps: ArrayLike) -> list[float]:
    """Return p with the step-down correction of S. Holm, Scand. J. Stat. 6 (1979), in their order; shape (test,).

    As statsmodels' ``multipletests``, which collects garbage at each call: a tenth of a second in a large process, and
    most of the time of an analysis.
    """
    corrected: list[float] = holm_rows(np.ravel(ps)).tolist()
    return corrected


def holm_rows(ps: ArrayLike) -> NDArray[np.float64]:
    """Return p of many families of tests, each corrected as by `holm`; shape (…, test)."""
    raw = np.asarray(ps, np.float64)
    order = np.argsort(raw, axis=-1, kind="stable")
    stepped = np.take_along_axis(raw, order, -1) * np.arange(raw.shape[-1], 0, -1)
    corrected = np.empty_like(raw)
    np.put_along_axis(corrected, order, np.minimum(np.maximum.accumulate(stepped, -1), 1.0), -1)
    return corrected
