"""Errors of what is felt and seen against what plates were scored, and their tests: Hatori et al. 2025, Sec. II-D.

The paper counts every answer as independent (n = 2,400 of 20 people) and compares with people of an earlier study. So
its Steel-Dwass tests stand here as printed, with what they take for granted, and beside them tests that go by person:
Friedman and Wilcoxon among conditions that the same people met, Mann-Whitney of people's means against other people.
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
from tactogram.statistics.multiplicity import holm
from tactogram.statistics.summary import GroupSummary, summary

Array = NDArray[np.float64]
ALPHA = 0.01
"""Sec. III-B: "at the 1% significance level"."""


def errors_of(
    table: Ratings, targets: Mapping[str, Sequence[float]], conditions: Sequence[str]
) -> dict[str, Array]:
    """Return the absolute errors of conditions that one group of people met, in points of the scale.

    Parameters
    ----------
    table : Ratings
        Of items called ``CONDITION/TARGET``.
    targets : mapping from str to sequence of float
        Mean scores of each target, in the order of ``table.words``.
    conditions : sequence of str

    Returns
    -------
    dict from str to float64 array, shape (rater, target, word)
        By condition; NaN where a score was not given. The raters are those of any of the conditions, sorted: row n is
        one person in all of them. The targets are those that were scored, in the order given.

    Raises
    ------
    ParameterError
        If a condition has no item.
    """
    place = {item: number for number, item in enumerate(table.items)}
    found: dict[str, Array] = {}
    for condition in conditions:
        met = [target for target in targets if f"{condition}/{target}" in place]
        if not met:
            raise ParameterError(
                f"nothing was scored of {condition}: items must be called {condition}/TARGET"
            )
        cube = table.cube[[place[f"{condition}/{target}"] for target in met]]  # target, rater, word
        wanted = np.array([targets[target] for target in met])
        found[condition] = np.abs(cube - wanted[:, None]).transpose(1, 0, 2)
    there = np.any([~np.isnan(errors).all((1, 2)) for errors in found.values()], axis=0)
    return {condition: errors[there] for condition, errors in found.items()}


@dataclass(frozen=True, eq=False)
class CrossModalResult:
    """Errors by condition, and what tests say of them.

    Parameters
    ----------
    overall : mapping from str to Summary
        Over all answers: mean and standard error as in Fig. 5.
    by_word : mapping from str to mapping from str to Summary
        By condition and word: Fig. 6.
    as_printed : Comparison
        Steel-Dwass over all answers.
    as_printed_by_word : mapping from str to Comparison
        The same per word, over `shown`.
    by_person : Comparison
        Friedman and Wilcoxon with Holm among the conditions that the later group met.
    against_earlier : mapping from str to mapping from str to float
        p of Mann-Whitney on people's means, by condition and earlier condition, Holm over all of them.
    """

    overall: Mapping[str, GroupSummary]
    by_word: Mapping[str, Mapping[str, GroupSummary]]
    as_printed: Comparison
    as_printed_by_word: Mapping[str, Comparison]
    by_person: Comparison
    against_earlier: Mapping[str, Mapping[str, float]]

    def improved(self, condition: str, over: str, *, alpha: float = 0.05) -> list[str]:
        """Return the words in which ``condition`` errs less than ``over``, by the tests as printed."""
        found = []
        for word, comparison in self.as_printed_by_word.items():
            lower = self.by_word[condition][word].mean < self.by_word[over][word].mean
            if lower and comparison.pair(condition, over).p < alpha:
                found.append(word)
        return found

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values, for JSON."""
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
        By condition; within each group the same people, in one order, as `errors_of` gives them: who did not meet a
        condition has NaN there, and no part in the tests that go by person among the later ones.
    words : sequence of str
    shown : sequence of str
        Conditions that are compared per word.
    """
    every = {**earlier, **later}
    flat = {name: _given(errors) for name, errors in every.items()}
    per_word = {
        word: {name: _given(errors[..., k]) for name, errors in every.items()} for k, word in enumerate(words)
    }
    people = {name: _by_person(errors) for name, errors in every.items()}
    asked = {name: _given(means) for name, means in people.items()}
    pairs = [(condition, other) for condition in later for other in earlier]
    ps = [mann_whitney({a: asked[a], b: asked[b]}, correction="none").pair(a, b).p for a, b in pairs]
    corrected = dict(zip(pairs, holm(ps), strict=True))
    return CrossModalResult(
        {name: summary(values) for name, values in flat.items()},
        {name: {word: summary(per_word[word][name]) for word in words} for name in every},
        steel_dwass(flat),
        {word: steel_dwass({name: per_word[word][name] for name in shown}) for word in words},
        friedman_wilcoxon({name: people[name] for name in later}),
        {condition: {other: corrected[condition, other] for other in earlier} for condition in later},
    )


def _by_person(errors: Array) -> Array:
    """Return each person's mean error, shape (rater,), NaN for who gave no answer."""
    given = ~np.isnan(errors)
    count = given.sum((1, 2))
    total = np.where(given, errors, 0).sum((1, 2))
    return np.asarray(np.divide(total, count, out=np.full(len(errors), np.nan), where=count > 0))


def _given(errors: Array) -> Array:
    values: Array = errors[~np.isnan(errors)]
    return values
