"""Item contrasts: each item against the other items that the same people answered."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactogram.statistics import nan_mean
from tactogram_study.analysis.findings import Finding
from tactogram_study.analysis.paired import holm_paired
from tactogram_study.answers import Answers

Numbers = NDArray[np.float64]
WHOLE, REST = "all words", "minus the mean of the others"


def item_contrasts(
    answers: Answers, measure: str, *, margin: float | None = None, per_word: bool = False
) -> list[Finding]:
    """Return each item's difference from the mean of the other items, paired by participant.

    Over all words with equal weights, and with ``per_word`` also for each word. p by Holm over items, and over items
    and words. A participant counts for an item if they answered the same word for it and for another. The findings are
    checks; there are none with one item or one participant.
    """
    items, words = answers.unique("stimulus"), answers.unique("question")
    gaps = gaps_to_the_rest(answers)
    counts = {item: len(answers.where(stimulus=item)) for item in items}
    means = nan_mean(gaps, 2)
    whole = {item: means[~np.isnan(means[:, k]), k] for k, item in enumerate(items)}
    found = holm_paired(
        {
            f"{item} {REST}, {WHOLE}": (people, counts[item])
            for item, people in whole.items()
            if len(people) > 1
        },
        measure,
        margin,
    )
    if not per_word:
        return found
    single = {
        f"{item} {REST}, {word}": (gaps[:, i, w][~np.isnan(gaps[:, i, w])], counts[item] // len(words))
        for i, item in enumerate(items)
        for w, word in enumerate(words)
    }
    kept = {of: gap for of, gap in single.items() if len(gap[0]) > 1}
    return found + holm_paired(kept, measure, margin)


def gaps_to_the_rest(answers: Answers) -> Numbers:
    """Return each participant's answer about an item minus the mean of the other items, for each word.

    Shape (participant, item, word); NaN where a participant lacks the word for the item, or for all others.
    """
    names = [answers.unique(name) for name in ("participant", "stimulus", "question")]
    places = [{name: k for k, name in enumerate(column)} for column in names]
    sums, counts = np.zeros((2, *map(len, names)))
    for row in answers:
        cell = places[0][row.participant], places[1][row.stimulus], places[2][row.question]
        sums[cell] += row.value
        counts[cell] += 1
    with np.errstate(invalid="ignore", divide="ignore"):
        means = sums / counts
        present = counts > 0
        others = present.sum(1, keepdims=True) - 1
        rest = (np.where(present, means, 0).sum(1, keepdims=True) - means) / others
        gaps: Numbers = means - rest
    gaps[~np.isfinite(gaps)] = np.nan
    return gaps
