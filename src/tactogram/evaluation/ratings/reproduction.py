"""Reproduction error: ratings of generated signals against those of the surfaces they stand for. Fig. 7 of [1].

What was rated is called ``CONDITION/TARGET``, such as ``D/plate03``, whoever rated it: people, simulated people, or a
rater model, which counts as one rater.

References
----------
[1] Hatori, K. & Takemura, K. (2023). Conditional generative adversarial network-based tactile stimulus generation for
    ultrasonic tactile display. IEEE Access.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings
from tactogram.errors import DataError, ParameterError
from tactogram.statistics.comparison import Comparison, paired_t, student_t
from tactogram.statistics.summary import summary

Floats = NDArray[np.float64]
STRAIGHT = "sensor"
"""The condition without a model: the sensor's signal straight to the display. Sec. V-A."""
NEAREST = "nearest"
"""Ours: the display signal whose mean scores are nearest to the surface's, which a model has to beat."""


@dataclass(frozen=True, eq=False)
class ReproductionErrors:
    """Absolute errors to the targets' mean scores.

    Parameters
    ----------
    errors : mapping from str to float64 array, shape (target, rater, word)
        By condition, points of the scale; NaN where nobody scored.
    targets, raters, words : sequence of str
    told_by : str
        Who scored, for every figure and table: ``people``, ``simulated raters`` or ``a rater model``.
    """

    errors: Mapping[str, Floats]
    targets: Sequence[str]
    raters: Sequence[str]
    words: Sequence[str]
    told_by: str

    def as_dict(self) -> dict[str, Any]:
        """Return the figures as JSON values.

        Returns
        -------
        dict
            ``told_by``; ``conditions``: of each ``mae``, ``se`` and ``n`` of all answers as printed, ``targets`` (how
            many were scored), ``se_by_rater`` (None of one rater), ``per_word``; ``incomplete``: conditions that lack a
            target, which are in no test; and ``tests``: ``as_printed`` (Student's t over all answers as if
            independent), ``by_rater`` (paired t over raters' means, Holm; None of one rater) and ``by_target`` (the
            same over targets), each a list of pairs.
        """
        rows = {name: self._row(errors) for name, errors in self.errors.items()}
        whole = {n: e for n, e in self.errors.items() if rows[n]["targets"] == len(self.targets)}
        return {
            "told_by": self.told_by,
            "raters": len(self.raters),
            "conditions": rows,
            "incomplete": [name for name in rows if name not in whole],
            "tests": {
                "as_printed": _pairs(student_t, {n: _given(e.ravel()) for n, e in whole.items()}),
                "by_rater": _pairs(paired_t, {n: _over(e, (0, 2)) for n, e in whole.items()}),
                "by_target": _pairs(paired_t, {n: _over(e, (1, 2)) for n, e in whole.items()}),
            },
        }

    def _row(self, errors: Floats) -> dict[str, Any]:
        whole = summary(errors)
        people = summary(_over(errors, (0, 2)))
        return {
            "mae": whole.mean,
            "se": _finite(whole.se),
            "n": whole.n,
            "targets": int((~np.isnan(errors).all((1, 2))).sum()),
            "se_by_rater": _finite(people.se),
            "per_word": dict(zip(self.words, _over(errors, (0, 1)).tolist(), strict=True)),
        }


def reproduction(
    ratings: Ratings, targets: Mapping[str, Floats], *, conditions: Sequence[str], told_by: str
) -> ReproductionErrors:
    """Return the errors of what was rated to the targets it stands for.

    Parameters
    ----------
    ratings : Ratings
        Of items ``CONDITION/TARGET``; others are left out.
    targets : mapping from str to float64 array, shape (word,)
        Mean scores on the scale of ``ratings``, in the order of its words.
    conditions : sequence of str
        In the order in which they are shown; those of which nothing was rated are left out.
    told_by : str

    Raises
    ------
    DataError
        If nothing of any condition was rated, or a target is unknown.
    """
    place = {item: number for number, item in enumerate(ratings.items)}
    found: dict[str, Floats] = {}
    for condition in conditions:
        rows = {item.partition("/")[2]: n for item, n in place.items() if item.partition("/")[0] == condition}
        if unknown := [name for name in rows if name not in targets]:
            raise DataError(f"{condition}/{unknown[0]}: target must be one of {', '.join(targets)}")
        if rows:
            nothing = np.full(ratings.cube.shape[1:], np.nan)
            found[condition] = np.array(
                [
                    np.abs(ratings.cube[rows[name]] - means) if name in rows else nothing
                    for name, means in targets.items()
                ]
            )
    if not found:
        raise DataError(
            f"ratings must be of items CONDITION/TARGET with a condition of {', '.join(conditions)}, "
            f"got {', '.join(ratings.items[:3])}"
        )
    return ReproductionErrors(found, tuple(targets), ratings.raters, ratings.words, told_by)


def constant_error(targets: Mapping[str, Floats]) -> float:
    """Return the mean absolute error of one answer for all targets: their mean."""
    scores = np.array(list(targets.values()))
    return float(np.nanmean(np.abs(scores - np.nanmean(scores, axis=0))))


def _pairs(test: Any, groups: Mapping[str, Floats]) -> list[dict[str, Any]] | None:
    """Return each pair of conditions, or None where there is too little to test."""
    try:
        found: Comparison = test(groups)
    except ParameterError:
        return None
    return [
        {
            "first": pair.first,
            "second": pair.second,
            "difference": pair.difference,
            "statistic": _finite(pair.statistic),
            "p": _finite(pair.p),
        }
        for pair in found.pairs
    ]


def _given(values: Floats) -> Floats:
    return values[~np.isnan(values)]


def _over(values: Floats, axes: tuple[int, ...]) -> Floats:
    """Return means over ``axes``, NaN where nothing was given."""
    given = ~np.isnan(values)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.where(given, values, 0).sum(axes) / given.sum(axes))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
