"""Reproduction errors: ratings of generated signals against those of the surfaces that they represent. Fig. 7 of [1].

Rated items are called ``CONDITION/TARGET``, such as ``D/plate03``. Raters are people, simulated people, or a
rater model, which counts as one rater.

The error alone says little, since scores near the middle have a small error for any label. So it is complemented by the
error of the same scores against other labels, and by correlation and slope of single scores over labels, without each
word's mean. Means over noises would hide that a generator almost ignores its label: a tiny shift in every image, which
nobody would see, gives a high correlation of means.

References
----------
[1] Hatori, K. & Takemura, K. (2023). Conditional generative adversarial network-based tactile stimulus generation for
    ultrasonic tactile display. IEEE Access.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings
from tactogram.errors import DataError, ParameterError
from tactogram.statistics.comparison import Comparison, paired_t, student_t
from tactogram.statistics.groups import nan_mean, summary
from tactogram.text_files import finite_json

Floats = NDArray[np.float64]
STRAIGHT = "sensor"
"""Condition without a model: the sensor's signal as the drive. Sec. V-A."""
NEAREST = "nearest"
"""Our condition: the display signal with mean scores nearest to the surface's, which a model must outperform."""
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ReproductionErrors:
    """Absolute errors from the targets' mean scores."""

    errors: Mapping[str, Floats]
    """By condition, points of the scale, shape (target, rater, word); NaN where missing."""
    targets: Sequence[str]
    raters: Sequence[str]
    words: Sequence[str]
    told_by: str
    """The raters, for figures and tables: ``people``, ``simulated raters`` or ``a rater model``."""

    def as_dict(self) -> dict[str, Any]:
        """Return the figures as JSON values.

        Keys of the result: ``told_by``; ``conditions``: for each ``mae``, ``se`` and ``n`` of all answers as printed,
        ``targets`` (number of rated ones), ``se_by_rater`` (None for one rater), ``per_word``; ``incomplete``:
        conditions that lack a target and are not tested; ``tests``: ``as_printed`` (Student's t over all answers as if
        independent), ``by_rater`` (paired t over raters' means, Holm; None for one rater) and ``by_target`` (the same
        over targets), each a list of pairs.
        """
        rows = {name: self._row(errors) for name, errors in self.errors.items()}
        whole = {n: e for n, e in self.errors.items() if rows[n]["targets"] == len(self.targets)}
        return {
            "told_by": self.told_by,
            "raters": len(self.raters),
            "conditions": rows,
            "incomplete": [name for name in rows if name not in whole],
            "tests": {
                "as_printed": _pairs(student_t, {n: e[~np.isnan(e)] for n, e in whole.items()}),
                "by_rater": _pairs(paired_t, {n: nan_mean(e, (0, 2)) for n, e in whole.items()}),
                "by_target": _pairs(paired_t, {n: nan_mean(e, (1, 2)) for n, e in whole.items()}),
            },
        }

    def _row(self, errors: Floats) -> dict[str, Any]:
        whole = summary(errors)
        people = summary(nan_mean(errors, (0, 2)))
        return {
            "mae": whole.mean,
            "se": finite_json(whole.se),
            "n": whole.n,
            "targets": int((~np.isnan(errors).all((1, 2))).sum()),
            "se_by_rater": finite_json(people.se),
            "per_word": dict(zip(self.words, nan_mean(errors, (0, 1)).tolist(), strict=True)),
        }


def reproduction(
    ratings: Ratings, targets: Mapping[str, Floats], *, conditions: Sequence[str], told_by: str
) -> ReproductionErrors:
    """Return the errors of rated items from their targets.

    Raises `DataError` if no condition was rated, or a target is unknown.

    Parameters
    ----------
    ratings : Ratings
        Ratings of items ``CONDITION/TARGET``; others are ignored.
    targets : mapping from str to float64 array, shape (word,)
        Mean scores on the scale of ``ratings``, in the order of its words.
    conditions : sequence of str
        In the order of tables; conditions without ratings are left out.
    told_by : str
        The raters.
    """
    index = {item: number for number, item in enumerate(ratings.items)}
    errors: dict[str, Floats] = {}
    for condition in conditions:
        rows = {item.partition("/")[2]: n for item, n in index.items() if item.partition("/")[0] == condition}
        if unknown := [name for name in rows if name not in targets]:
            raise DataError(f"{condition}/{unknown[0]}: target must be one of {', '.join(targets)}")
        if rows:
            nothing = np.full(ratings.cube.shape[1:], np.nan)
            errors[condition] = np.array(
                [
                    np.abs(ratings.cube[rows[name]] - means) if name in rows else nothing
                    for name, means in targets.items()
                ]
            )
    if not errors:
        raise DataError(
            f"ratings must be of items CONDITION/TARGET with a condition of {', '.join(conditions)}, "
            f"got {', '.join(ratings.items[:3])}"
        )
    return ReproductionErrors(errors, tuple(targets), ratings.raters, ratings.words, told_by)


def constant_error(targets: Mapping[str, Floats]) -> float:
    """Return the mean absolute error of guessing the mean of all targets."""
    scores = np.array(list(targets.values()))
    return float(np.nanmean(np.abs(scores - np.nanmean(scores, axis=0))))


def _pairs(test: Any, groups: Mapping[str, Floats]) -> list[dict[str, Any]] | None:
    """Return each pair of conditions, or None with too little data for a test."""
    try:
        comparison: Comparison = test(groups)
    except ParameterError:
        return None
    return [
        {
            "first": pair.first,
            "second": pair.second,
            "difference": pair.difference,
            "statistic": finite_json(pair.statistic),
            "p": finite_json(pair.p),
        }
        for pair in comparison.pairs
    ]


@dataclass(frozen=True)
class LabelFidelity:
    """Agreement of scores of generated items with the requested ones."""

    error: float
    """Mean absolute error, in units of the scores."""
    error_of_others: float
    """Mean absolute error against every other label; larger than ``error`` if labels are followed."""
    correlation: float
    """Correlation with the label over labels, draws and words, without each word's mean; 0 for constant scores."""
    slope: float
    """Change of the scores per change of the label: 1 follows it fully, 0 not at all."""
    by_word: tuple[float, ...]
    """Correlation of each word."""

    def as_dict(self) -> dict[str, float | list[float]]:
        """Return plain values for JSON."""
        return {**asdict(self), "by_word": list(self.by_word)}


def label_fidelity(asked: Array, said: Array) -> LabelFidelity:
    """Return how closely ``said`` follows ``asked``.

    Raises `ParameterError` if the shapes do not fit.

    Parameters
    ----------
    asked : float array, shape (label, word)
        At least 3 labels.
    said : float array, shape (label, draw, word)
        Scores of items generated for each label from several noises.
    """
    if said.ndim != 3 or asked.shape != (len(said), said.shape[2]) or len(asked) < 3:
        raise ParameterError.must(
            "asked",
            "be (label, word) of at least 3 labels and said (label, draw, word), "
            f"got {asked.shape} and {said.shape}",
        )
    errors = np.abs(said[:, None] - asked[None, :, None]).mean((2, 3))  # of each score against each label
    own = np.eye(len(asked), dtype=bool)
    target = np.broadcast_to((asked - asked.mean(0))[:, None], said.shape)
    heard = said - said.mean((0, 1))
    by_word = tuple(_correlation(target[..., word], heard[..., word]) for word in range(asked.shape[1]))
    power = float(np.sum(target**2))
    return LabelFidelity(
        float(errors[own].mean()),
        float(errors[~own].mean()),
        _correlation(target, heard),
        float(np.sum(target * heard)) / power if power > 0 else 0.0,
        by_word,
    )


def _correlation(a: Array, b: Array) -> float:
    """Return the correlation of two deviations from a mean; 0 where one does not vary."""
    power = float(np.sqrt(np.sum(a**2) * np.sum(b**2)))
    return float(np.sum(a * b) / power) if power > 1e-12 else 0.0
