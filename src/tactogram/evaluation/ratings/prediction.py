"""Prediction errors of scores, compared with a constant guess and with the agreement of raters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import stats

from tactogram.statistics.figures import BLUE, GRAY
from tactogram.statistics.groups import nan_mean
from tactogram.text_files import finite_json

Floats = NDArray[np.float64]
SPLITS = 100
"""Random halves of the raters in a split-half error."""
FEWEST_PAIRS = 3
"""Fewest items of a rank correlation."""


@dataclass(frozen=True, eq=False)
class PredictedRatings:
    """Predictions of one or several repetitions and people's ratings, in points of the scale."""

    words: Sequence[str]
    items: Sequence[str]
    scores: Floats
    """Shape (repetition, item, word); NaN where an item was not predicted."""
    constant: Floats
    """The constant guess: the mean of the training scores; shape as ``scores``."""
    truth: Floats
    """Mean ratings to be predicted; shape as ``scores``."""
    cube: Floats
    """Every rater's scores, shape (item, rater, word); NaN where missing."""

    @property
    def errors(self) -> Floats:
        """Absolute error, shape (repetition, item, word)."""
        return np.asarray(np.abs(self.scores - self.truth))

    @property
    def constant_errors(self) -> Floats:
        """Absolute error of the constant guess, shape (repetition, item, word)."""
        return np.asarray(np.where(np.isnan(self.scores), np.nan, np.abs(self.constant - self.truth)))

    def as_dict(self, *, seed: int = 0) -> dict[str, Any]:
        """Return the figures as JSON values.

        Keys of the result: ``per_word`` (word to row) and ``mean`` (over words). A row has ``mae``, ``mae_sd`` (over
        repetitions, None of one), ``constant_mae``, ``p_against_constant`` (Wilcoxon's signed ranks over items,
        two-sided, not corrected), ``split_half_mae`` and ``one_rater_mae`` (None with fewer than four, or two, raters)
        and ``rank_correlation`` (Spearman, over items, mean over repetitions) with ``rank_correlation_sd``.
        """
        rng = np.random.default_rng(seed)
        split, alone = split_half_error(self.cube, rng=rng), one_rater_error(self.cube)
        rows = {
            word: self._row(np.s_[..., n : n + 1])
            | {"split_half_mae": finite_json(split[n]), "one_rater_mae": finite_json(alone[n])}
            for n, word in enumerate(self.words)
        }
        correlations = [row["rank_correlation"] for row in rows.values()]
        known = [value for value in correlations if value is not None]
        mean = self._row(np.s_[...]) | {
            "split_half_mae": finite_json(np.nanmean(split) if not np.isnan(split).all() else np.nan),
            "one_rater_mae": finite_json(np.nanmean(alone) if not np.isnan(alone).all() else np.nan),
            "rank_correlation": float(np.mean(known)) if known else None,
            "rank_correlation_sd": None,
        }
        return {"per_word": rows, "mean": mean}

    def _row(self, part: Any) -> dict[str, Any]:
        errors, guess = self.errors[part], self.constant_errors[part]
        runs = nan_mean(errors, (1, 2))
        runs = runs[~np.isnan(runs)]  # NaN if all people left a word out
        gain = nan_mean(guess, (0, 2)) - nan_mean(errors, (0, 2))
        gain = gain[~np.isnan(gain)]
        row: dict[str, Any] = {
            "mae": float(np.nanmean(errors)),
            "mae_sd": float(runs.std(ddof=1)) if len(runs) > 1 else None,
            "constant_mae": float(np.nanmean(guess)),
            "p_against_constant": float(stats.wilcoxon(gain).pvalue) if np.any(gain) else None,
        }
        correlations = [
            _correlation(s.ravel(), t.ravel())
            for s, t in zip(self.scores[part], self.truth[part], strict=True)
        ]
        known = [value for value in correlations if value is not None]
        row["rank_correlation"] = float(np.mean(known)) if known else None
        row["rank_correlation_sd"] = float(np.std(known, ddof=1)) if len(known) > 1 else None
        return row


def split_half_error(cube: Floats, *, rng: np.random.Generator, splits: int = SPLITS) -> Floats:
    """Return the mean absolute difference between means of two halves of the raters, shape (word,).

    NaN with fewer than four raters. Halves have half as many raters, so means over all raters differ less.
    ``cube`` has shape (item, rater, word) with NaN where missing.
    """
    raters = cube.shape[1]
    if raters < 4:
        return np.full(cube.shape[2], np.nan)
    differences = []
    for _ in range(splits):
        drawn = rng.permutation(raters)
        one, other = cube[:, drawn[: raters // 2]], cube[:, drawn[raters // 2 :]]
        differences.append(np.abs(nan_mean(one, 1) - nan_mean(other, 1)))
    return nan_mean(np.array(differences), (0, 1))


def one_rater_error(cube: Floats) -> Floats:
    """Return the mean absolute difference between a rater and the mean of the others, shape (word,).

    NaN with fewer than two raters. ``cube`` as for `split_half_error`.
    """
    if cube.shape[1] < 2:
        return np.full(cube.shape[2], np.nan)
    rated = ~np.isnan(cube)
    total, count = np.where(rated, cube, 0).sum(1, keepdims=True), rated.sum(1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        others = (total - cube) / (count - 1)
    return nan_mean(np.abs(cube - others), (0, 1))


def _correlation(said: Floats, truth: Floats) -> float | None:
    both = ~(np.isnan(said) | np.isnan(truth))
    if both.sum() < FEWEST_PAIRS or np.ptp(said[both]) == 0 or np.ptp(truth[both]) == 0:
        return None
    return float(stats.spearmanr(said[both], truth[both]).statistic)


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
    truth, said = nan_mean(found.truth, 0), nan_mean(found.scores, 0)
    ends = [float(np.nanmin([truth, said])), float(np.nanmax([truth, said]))]
    right.plot(ends, ends, color=GRAY, lw=0.8)
    right.plot(truth.ravel(), said.ravel(), ".", color=BLUE, alpha=0.4, ms=4)
    right.set(xlabel="given (mean of the raters)", ylabel="predicted, item held out", aspect="equal")
    return figure
