"""Means by participant: the analysis of a design that has none of its own."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np

from tactogram.statistics.summary import summary
from tactogram.study.analysis.findings import AnalysisSection, Finding, answered, section_of
from tactogram.study.analysis.paired import holm_paired
from tactogram.study.answers import Answers


def analyse_means(answers: Answers, *, title: str, margin: float | None = None) -> AnalysisSection:
    """Return the mean of each stimulus and condition over participants, and the differences between conditions.

    Confirmatory are the differences, each participant's mean over stimuli paired: Student's t with Holm's correction
    over the pairs of conditions.

    Parameters
    ----------
    answers : Answers
        To one question; ``value`` is what is averaged.
    title : str
    margin : float, optional
        Of a difference between conditions, given before the answers were seen.

    Raises
    ------
    DataError
        If no answer is a number.
    """
    kept, notes = answered(answers, title)
    rows: list[dict[str, Any]] = []
    for (stimulus, condition), own in _cells(kept).items():
        found = summary(list(own.values()))
        one = found.n == 1
        rows.append(
            {
                "stimulus": stimulus,
                "condition": condition,
                "mean": found.mean,
                "low": None if one else found.low,
                "high": None if one else found.high,
                "participants": found.n,
            }
        )
    findings = _differences(kept, margin)
    if not findings:
        notes += ("one condition or one participant: nothing is compared",)
    return section_of(kept, title, findings, {"means over participants": rows}, notes)


def _cells(kept: Answers) -> dict[tuple[str, str], dict[str, float]]:
    """Return each participant's mean by stimulus and condition."""
    values: dict[tuple[str, str], dict[str, list[float]]] = {}
    for row in kept:
        own = values.setdefault((row.stimulus, row.condition), {})
        own.setdefault(row.participant, []).append(row.value)
    return {key: {who: float(np.mean(v)) for who, v in own.items()} for key, own in values.items()}


def _differences(kept: Answers, margin: float | None) -> list[Finding]:
    """Return the paired differences of every two conditions that two participants or more met."""
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
