"""Figures of predicted and given scores, and of the space of words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tactogram.evaluation.ratings.prediction import PredictedRatings
from tactogram.statistics.figures import BLUE, GRAY
from tactogram.statistics.groups import nan_mean


def prediction_figure(found: PredictedRatings, figures: Mapping[str, Any], *, title: str = "") -> Figure:
    """Draw the error of each word beside constant guess and people, and predicted over given scores.

    ``figures`` is ``found.as_dict()``.
    """
    rows = figures["per_word"]
    figure = Figure(figsize=(10.5, 1.6 + 0.36 * max(len(rows), 7)), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.5, 1))
    names, places = list(rows), np.arange(len(rows))
    for column, text, colour, mark in (
        ("constant_mae", "constant guess (training mean)", GRAY, "|"),
        ("one_rater_mae", "one rater and the others' mean", "#b9a0d6", "d"),
        ("split_half_mae", "one half of the raters and the other", "#4d9221", "s"),
    ):
        values = [rows[name][column] for name in names]
        if any(value is not None for value in values):
            shown = [np.nan if value is None else value for value in values]
            left.plot(shown, places, mark, color=colour, ms=10 if mark == "|" else 5, mew=2, label=text)
    spread = [rows[name]["mae_sd"] or 0.0 for name in names]
    left.errorbar(
        [rows[n]["mae"] for n in names], places, xerr=spread, fmt="o", color=BLUE, ms=6, label="predicted"
    )
    left.set_yticks(places, names)
    left.invert_yaxis()
    left.set_xlim(left=0)
    left.set(xlabel="mean absolute error, points of the scale", title=title)
    left.grid(axis="x", alpha=0.3)
    figure.legend(loc="outside lower left", fontsize=8, frameon=False, ncols=2)
    given, said = nan_mean(found.truth, 0), nan_mean(found.scores, 0)
    ends = [float(np.nanmin([given, said])), float(np.nanmax([given, said]))]
    right.plot(ends, ends, color=GRAY, lw=0.8)
    right.plot(given.ravel(), said.ravel(), ".", color=BLUE, alpha=0.4, ms=4)
    right.set(xlabel="given (mean of the raters)", ylabel="predicted, item held out", aspect="equal")
    return figure
