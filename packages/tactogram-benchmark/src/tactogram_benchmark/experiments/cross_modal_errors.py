"""Errors of ratings of touch with images against the plates' ratings, their tests and figures: Hatori et al. 2025.

The paper (Sec. II-D) treats every answer as independent (n = 2,400 of 20 people) and compares with the people of an
earlier study. Its Steel-Dwass tests are computed as printed, and tests by person are added: Friedman and Wilcoxon among
conditions with the same people, Mann-Whitney on people's means between the groups.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.datasets import Ratings
from tactogram.errors import ParameterError
from tactogram.statistics import (
    Comparison,
    GroupSummary,
    friedman_wilcoxon,
    holm,
    mann_whitney,
    nan_mean,
    steel_dwass,
    summary,
)

Array = NDArray[np.float64]
ALPHA = 0.01
"""Sec. III-B: "at the 1% significance level"."""
COLOURS = {"first": "0.55", "second": "tab:blue", "weights": "tab:orange"}
STARS = ((0.01, "**"), (0.05, "*"))
"""As in the paper's captions."""


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
    row_of = {item: number for number, item in enumerate(table.items)}
    errors_by_condition: dict[str, Array] = {}
    for condition in conditions:
        rated = [target for target in targets if f"{condition}/{target}" in row_of]
        if not rated:
            raise ParameterError(f"{condition}: has no ratings; items must be called {condition}/TARGET")
        cube = table.cube[[row_of[f"{condition}/{target}"] for target in rated]]  # target, rater, word
        requested = np.array([targets[target] for target in rated])
        errors_by_condition[condition] = np.abs(cube - requested[:, None]).transpose(1, 0, 2)
    present = np.any([~np.isnan(errors).all((1, 2)) for errors in errors_by_condition.values()], axis=0)
    return {condition: errors[present] for condition, errors in errors_by_condition.items()}


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
        improved_words = []
        for word, comparison in self.as_printed_by_word.items():
            lower = self.by_word[condition][word].mean < self.by_word[over][word].mean
            if lower and comparison.pair(condition, over).p < alpha:
                improved_words.append(word)
        return improved_words

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
        return {
            "overall": {name: vars(error) for name, error in self.overall.items()},
            "by_word": {
                name: {word: vars(error) for word, error in row.items()} for name, row in self.by_word.items()
            },
            "as_printed": self.as_printed.as_dict(),
            "as_printed_by_word": {word: test.as_dict() for word, test in self.as_printed_by_word.items()},
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


def stars(p: float) -> str:
    """Return ``**`` below 0.01, ``*`` below 0.05, else nothing."""
    return next((mark for limit, mark in STARS if p < limit), "")


def overall_figure(
    found: CrossModalResult, *, against: str, published: Mapping[str, float], told_by: str
) -> Figure:
    """Draw the mean absolute error of each condition with its standard error: Fig. 5.

    Stars mark differences from the condition ``against``, by Steel-Dwass as printed; ``published`` has the paper's
    errors by condition, ``told_by`` the raters for the title.
    """
    names = list(found.overall)
    figure = Figure(figsize=(7.5, 4.2), layout="constrained")
    axes = figure.subplots()
    means, errors = ([getattr(found.overall[name], part) for name in names] for part in ("mean", "se"))
    axes.bar(
        range(len(names)), means, yerr=errors, capsize=3, color=_colours(names), width=0.65, label="ours"
    )
    for x, name in enumerate(names):
        mark = "" if name == against else _mark(found.as_printed, name, against)
        axes.text(x, means[x] + errors[x] + 0.03, f"{means[x]:.2f}{mark}", ha="center", fontsize=8)
        if name in published:
            axes.plot([x - 0.33, x + 0.33], [published[name]] * 2, color="k", linestyle=":", linewidth=1.5)
    if published:
        axes.plot([], [], color="k", linestyle=":", label="published (people)")
    axes.set_xticks(range(len(names)), [name.replace(" ", "\n", 1) for name in names], fontsize=8)
    axes.set_ylim(0, 1.2 * max([*means, *published.values()]))
    axes.set_ylabel("mean absolute error, points of 7")
    n = found.overall[names[0]].n
    axes.set_title(
        f"Fig. 5, {told_by}; n = {n:,} answers, mean ± SE\n** p < 0.01, * p < 0.05 against {against} (↑ larger), "
        "Steel-Dwass as printed (treats answers as independent)",
        fontsize=9,
    )
    axes.legend(fontsize=8, loc="upper right")
    return figure


def per_word_figure(found: CrossModalResult, conditions: Sequence[str], *, told_by: str) -> Figure:
    """Draw the error of each word by condition, with stars for differences from the first: Fig. 6."""
    words = list(found.as_printed_by_word)
    figure = Figure(figsize=(10, 4), layout="constrained")
    axes = figure.subplots()
    width = 0.8 / len(conditions)
    for number, (name, colour) in enumerate(zip(conditions, _colours(conditions), strict=True)):
        places = np.arange(len(words)) + (number - (len(conditions) - 1) / 2) * width
        rows = [found.by_word[name][word] for word in words]
        axes.bar(
            places,
            [row.mean for row in rows],
            width,
            yerr=[row.se for row in rows],
            capsize=2,
            color=colour,
            label=name,
        )
        if number:
            _star(axes, found, conditions[0], name, places, words)
    axes.set_xticks(range(len(words)), words)
    axes.set_ylim(0, 1.25 * max(found.by_word[name][word].mean for name in conditions for word in words))
    axes.set_ylabel("mean absolute error, points of 7")
    n = found.by_word[conditions[0]][words[0]].n
    axes.set_title(
        f"Fig. 6, {told_by}; n = {n:,} answers per word, mean ± SE; ** p < 0.01, * p < 0.05 against {conditions[0]} "
        "(↑ larger), Steel-Dwass",
        fontsize=9,
    )
    axes.legend(fontsize=8, ncols=len(conditions), loc="upper right")
    return figure


def _mark(comparison: Comparison, name: str, against: str) -> str:
    """Return the stars of a difference, with an arrow where ``name`` errs more."""
    mark = stars(comparison.pair(name, against).p)
    worse = comparison.groups[name].mean > comparison.groups[against].mean
    return f"{mark}↑" if mark and worse else mark


def _star(
    axes: Axes, comparison: CrossModalResult, first: str, name: str, places: np.ndarray, words: Sequence[str]
) -> None:
    for x, word in zip(places, words, strict=True):
        row = comparison.by_word[name][word]
        mark = _mark(comparison.as_printed_by_word[word], name, first)
        axes.text(x, row.mean + row.se + 0.02, mark, ha="center", fontsize=8)


def _colours(names: Sequence[str]) -> list[str]:
    order = list(COLOURS.values())
    return [order[min(number, 2)] for number in range(len(names))]
