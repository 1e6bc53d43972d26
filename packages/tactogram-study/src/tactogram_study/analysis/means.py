"""Means by participant: the default analysis of a design."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from tactogram.statistics import summary
from tactogram_study.analysis.findings import AnalysisSection, Finding, numeric_answers, section_of
from tactogram_study.analysis.paired import holm_paired
from tactogram_study.answers import Answers


def analyse_means(answers: Answers, *, title: str, margin: float | None = None) -> AnalysisSection:
    """Return the mean of each stimulus and condition over participants, and the differences between conditions.

    Confirmatory are the differences, each participant's mean over stimuli paired: Student's t with Holm's correction
    over the pairs of conditions. Raises `DataError` if no answer is a number.
    """
    kept, notes = numeric_answers(answers, title)
    rows: list[dict[str, Any]] = []
    for (stimulus, condition), means in kept.participant_means("stimulus", "condition").items():
        found = summary(means)
        single = found.n == 1
        rows.append(
            {
                "stimulus": stimulus,
                "condition": condition,
                "mean": found.mean,
                "low": None if single else found.low,
                "high": None if single else found.high,
                "participants": found.n,
            }
        )
    findings = _differences(kept, margin)
    if not findings:
        notes += ("one condition or one participant: nothing is compared",)
    return section_of(kept, title, findings, {"means over participants": rows}, notes)


def _differences(kept: Answers, margin: float | None) -> list[Finding]:
    """Return the paired differences of every two conditions that two or more participants answered."""
    means = {
        condition: {who: float(rows.numbers().mean()) for who, rows in group.by("participant").items()}
        for condition, group in kept.by("condition").items()
    }
    gaps = {}
    for first, second in combinations(sorted(means), 2):
        both = [who for who in means[first] if who in means[second]]
        if len(both) > 1:
            apart = np.array([means[first][who] - means[second][who] for who in both])
            count = len(kept.where(condition=(first, second)))
            gaps[f"{first} minus {second}"] = (apart, count)
    return holm_paired(gaps, "difference of means", margin, ("confirmatory", "check")) if gaps else []
