"""Errors of ratings of touch with images against the plates' ratings, and their tests: Hatori et al. 2025, Sec. II-D.

The paper treats every answer as independent (n = 2,400 of 20 people) and compares with the people of an earlier study.
Its Steel-Dwass tests are computed as printed, and tests by person are added: Friedman and Wilcoxon among conditions
with the same people, Mann-Whitney on people's means between the groups.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings
from tactogram.errors import ParameterError
from tactogram.statistics.comparison import Comparison, friedman_wilcoxon, mann_whitney, steel_dwass
from tactogram.statistics.groups import GroupSummary, holm, nan_mean, summary

Array = NDArray[np.float64]
ALPHA = 0.01
"""Sec. III-B: "at the 1% significance level"."""


def errors_of(
    table: Ratings, targets: Mapping[str, Sequence[float]], conditions: Sequence[str]
) -> dict[str, Array]:
    """Return the absolute errors of conditions with the same people, in points of the scale.

    ``table``: ratings of items called ``CONDITION/TARGET``. ``targets``: mean scores of each target, in the order of
    ``table.words``.

    Raises `ParameterError` if a condition has no item.

    Returns
    -------
    dict from str to float64 array, shape (rater, target, word)
        By condition; NaN for missing scores. Raters of any condition, sorted: row n is the same
        person everywhere. Rated targets in the given order.
    """
    place = {item: number for number, item in enumerate(table.items)}
    found: dict[str, Array] = {}
    for condition in conditions:
        rated = [target for target in targets if f"{condition}/{target}" in place]
        if not rated:
            raise ParameterError(f"{condition}: has no ratings; items must be called {condition}/TARGET")
        cube = table.cube[[place[f"{condition}/{target}"] for target in rated]]  # target, rater, word
        wanted = np.array([targets[target] for target in rated])
        found[condition] = np.abs(cube - wanted[:, None]).transpose(1, 0, 2)
    present = np.any([~np.isnan(errors).all((1, 2)) for errors in found.values()], axis=0)
    return {condition: errors[present] for condition, errors in found.items()}


@dataclass(frozen=True, eq=False)
class CrossModalResult:
    """Errors by condition, and their tests."""

    overall: Mapping[str, GroupSummary]
    """Over all answers: mean and standard error as in Fig. 5."""
    by_word: Mapping[str, Mapping[str, GroupSummary]]
    """By condition and word: Fig. 6."""
    as_printed: Comparison
    """Steel-Dwass over all answers."""
    as_printed_by_word: Mapping[str, Comparison]
    by_person: Comparison
    """Friedman and Wilcoxon with Holm's correction among the conditions of the later group."""
    against_earlier: Mapping[str, Mapping[str, float]]
    """p of Mann-Whitney on people's means, by condition and earlier condition, with Holm's correction."""

    def improved(self, condition: str, over: str, *, alpha: float = 0.05) -> list[str]:
        """Return the words with smaller errors in ``condition`` than in ``over``, by the tests as printed."""
        found = []
        for word, comparison in self.as_printed_by_word.items():
            lower = self.by_word[condition][word].mean < self.by_word[over][word].mean
            if lower and comparison.pair(condition, over).p < alpha:
                found.append(word)
        return found

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {
            "overall": {name: vars(one) for name, one in self.overall.items()},
            "by_word": {
                name: {word: vars(one) for word, one in row.items()} for name, row in self.by_word.items()
            },
            "as_printed": self.as_printed.as_dict(),
            "as_printed_by_word": {word: one.as_dict() for word, one in self.as_printed_by_word.items()},
            "by_person": self.by_person.as_dict(),
            "against_earlier": {name: dict(row) for name, row in self.against_earlier.items()},
        }


def compare_cross_modal(
    earlier: Mapping[str, Array], later: Mapping[str, Array], words: Sequence[str], *, shown: Sequence[str]
) -> CrossModalResult:
    """Return summaries and tests of the errors of two groups of people.

    Parameters
    ----------
    earlier, later : mapping from str to float64 array, shape (rater, target, word)
        By condition, as from `errors_of`. People without answers in one of the later conditions are left out of the
        tests by person among these.
    shown : sequence of str
        Conditions compared per word.
    """
    every = {**earlier, **later}
    flat = {name: _given(errors) for name, errors in every.items()}
    per_word = {
        word: {name: _given(errors[..., k]) for name, errors in every.items()} for k, word in enumerate(words)
    }
    people = {name: nan_mean(errors, (1, 2)) for name, errors in every.items()}
    means = {name: _given(values) for name, values in people.items()}
    pairs = [(condition, other) for condition in later for other in earlier]
    ps = [mann_whitney({a: means[a], b: means[b]}).pair(a, b).p for a, b in pairs]
    corrected = dict(zip(pairs, holm(ps), strict=True))
    return CrossModalResult(
        {name: summary(values) for name, values in flat.items()},
        {name: {word: summary(per_word[word][name]) for word in words} for name in every},
        steel_dwass(flat),
        {word: steel_dwass({name: per_word[word][name] for name in shown}) for word in words},
        friedman_wilcoxon({name: people[name] for name in later}),
        {condition: {other: corrected[condition, other] for other in earlier} for condition in later},
    )


def _given(errors: Array) -> Array:
    values: Array = errors[~np.isnan(errors)]
    return values
