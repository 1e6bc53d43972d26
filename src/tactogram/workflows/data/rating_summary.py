"""Summary of a store's ratings: content, gaps, reliability."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings, Scale
from tactogram.errors import MissingExtraError
from tactogram.statistics.reliability import Level, alpha_library, intraclass_correlation, krippendorff_alpha


def ratings_info(ratings: Ratings) -> dict[str, Any]:
    """Return the content of ratings, the missing scores, and the agreement of raters.

    Keys of the result: ``scale``, ``words``, ``items``, ``raters``, ``scores``; ``missing``: ``blank`` (words without a
    score where the rater scored others of the item, in all), ``blank_by_rater``, and ``not_met`` (pairs of a rater and
    an item without any score); ``reliability``: ``level``, ``words``: of each ``mean``, ``sd``, ``alpha``,
    ``icc_single``, ``icc_average``, ``icc_items``, ``icc_raters`` (null where it cannot be computed);
    ``alpha_missing``: why no alpha is there, without the extra ``statistics``.
    """
    cube = ratings.cube
    given = np.asarray(~np.isnan(cube))
    met = np.asarray(given.any(axis=2))
    blank = (~given & met[:, :, None]).sum((0, 2))
    level, missing = _level(ratings.scale), _alpha_missing()
    return {
        "scale": asdict(ratings.scale),
        "words": list(ratings.words),
        "items": len(ratings.items),
        "raters": len(ratings.raters),
        "scores": len(ratings),
        "missing": {
            "blank": int(blank.sum()),
            "blank_by_rater": {
                name: int(count) for name, count in zip(ratings.raters, blank, strict=True) if count
            },
            "not_met": int((~met).sum()),
        },
        "reliability": {
            "level": level,
            "words": {
                word: _word(cube[:, :, place], level, missing) for place, word in enumerate(ratings.words)
            },
            **({"alpha_missing": missing} if missing else {}),
        },
    }


def _word(scores: NDArray[np.float64], level: Level, missing: str) -> dict[str, float | int | None]:
    given = scores[~np.isnan(scores)]
    known: dict[str, float | int | None] = {
        "mean": float(given.mean()) if given.size else None,
        "sd": float(given.std(ddof=1)) if given.size > 1 else None,
        "alpha": None if missing else krippendorff_alpha(scores, level=level),
    }
    found = intraclass_correlation(scores)
    return known | {
        "icc_single": None if found is None else found.single,
        "icc_average": None if found is None else found.average,
        "icc_items": None if found is None else found.items,
        "icc_raters": None if found is None else found.raters,
    }


def _alpha_missing() -> str:
    """Return what is to be installed for Krippendorff's alpha; empty if it can be computed."""
    try:
        alpha_library()
    except MissingExtraError as error:
        return str(error)
    return ""


def _level(scale: Scale) -> Level:
    """Return the level of measurement: nominal for two answers, ordinal for points, interval for a continuum."""
    if scale.step is None:
        return "interval"
    return "nominal" if scale.high - scale.low <= scale.step else "ordinal"
