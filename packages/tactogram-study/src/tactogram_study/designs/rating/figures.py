"""Figures of ratings: the means of conditions, and of words by condition."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tactogram.signal import AXIS_COLOURS
from tactogram.statistics import GRAY, error_figure
from tactogram_study.analysis.figures import title_of
from tactogram_study.analysis.findings import SHOWN, AnalysisSection

MOST_BRACKETS = 6
"""With more, only those with the first condition are drawn."""


def conditions_figure(section: AnalysisSection) -> Figure:
    """Draw the mean of each condition like Fig. 7 and Fig. 5, with brackets where participants show a difference.

    Bars have the standard error of all scores, as printed; brackets follow Wilcoxon's signed ranks by participant, with
    Holm's correction.
    """
    measure, rows = next(iter(section.tables.items()))
    shown = {str(row["condition"]): (row["mean"], row["se_as_printed"] or 0.0) for row in rows}
    marked = []
    for finding in section.role("confirmatory"):
        first, divider, second = finding.of.partition(" minus ")
        if divider and finding.p is not None and finding.verdict == SHOWN:
            marked.append((first, second, "**" if finding.p < 0.01 else "*"))
    marked.sort(key=lambda pair: abs(list(shown).index(pair[0]) - list(shown).index(pair[1])))
    if len(marked) > MOST_BRACKETS:
        marked = [pair for pair in marked if pair[0] == next(iter(shown))]
    n = rows[0]["n"]
    title = f"{title_of(section)}\nn = {n:,} scores, mean ± SE; *: p < .05, **: p < .01 by participant"
    figure = error_figure(shown, marked=marked, label=measure, title=title)
    figure.set_size_inches(max(6.4, 2.2 + 1.05 * len(rows)), 4.8)
    return figure


def words_figure(section: AnalysisSection) -> Figure:
    """Draw each word under each condition with bootstrap intervals by participant, like Fig. 6."""
    name, rows = list(section.tables.items())[1]
    conditions = list(dict.fromkeys(str(row["condition"]) for row in rows))
    words = list(dict.fromkeys(str(row["word"]) for row in rows))
    figure = Figure(figsize=(2.4 + 0.85 * len(words), 4.4), layout="constrained")
    axes = figure.add_subplot()
    width = 0.8 / len(conditions)
    colours = (GRAY, *AXIS_COLOURS)
    for k, condition in enumerate(conditions):
        by_word = {row["word"]: row for row in rows if row["condition"] == condition}
        table = np.array(
            [[by_word.get(w, {}).get(key, np.nan) for key in ("mean", "low", "high")] for w in words], float
        )
        at = np.arange(len(words)) + width * (k - (len(conditions) - 1) / 2)
        away = np.nan_to_num(np.abs(table[:, 1:] - table[:, :1]).T)
        axes.bar(
            at, table[:, 0], 0.92 * width, yerr=away, color=colours[k % len(colours)], label=condition,
            error_kw={"lw": 0.8}, capsize=1.5,
        )  # fmt: skip
    axes.set_xticks(range(len(words)), words, rotation=25)
    axes.set_ylabel(f"{name.removesuffix(', per word')}\n(95 % by participant)")
    axes.set_ylim(bottom=0)
    axes.set_title(title_of(section), fontsize=10)
    if any(conditions):  # one condition may have no name
        figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    return figure
