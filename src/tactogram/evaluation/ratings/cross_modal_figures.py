"""Figures 5 and 6 of Hatori et al. 2025: errors of conditions, overall and per word, with the tests as printed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactogram.evaluation.ratings.cross_modal import CrossModalResult
from tactogram.statistics.comparison import Comparison

COLOURS = {"first": "0.55", "second": "tab:blue", "weights": "tab:orange"}
STARS = ((0.01, "**"), (0.05, "*"))
"""As in the paper's captions."""


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
    for place, name in enumerate(names):
        mark = "" if name == against else _mark(found.as_printed, name, against)
        axes.text(
            place, means[place] + errors[place] + 0.03, f"{means[place]:.2f}{mark}", ha="center", fontsize=8
        )
        if name in published:
            axes.plot(
                [place - 0.33, place + 0.33], [published[name]] * 2, color="k", linestyle=":", linewidth=1.5
            )
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
    axes: Axes, found: CrossModalResult, first: str, name: str, places: np.ndarray, words: Sequence[str]
) -> None:
    for place, word in zip(places, words, strict=True):
        row = found.by_word[name][word]
        mark = _mark(found.as_printed_by_word[word], name, first)
        axes.text(place, row.mean + row.se + 0.02, mark, ha="center", fontsize=8)


def _colours(names: Sequence[str]) -> list[str]:
    order = list(COLOURS.values())
    return [order[min(number, 2)] for number in range(len(names))]
