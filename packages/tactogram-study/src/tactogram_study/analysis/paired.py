"""Paired tests of participants' differences: Student's t, Wilcoxon's signed ranks, and equivalence.

Between conditions (the default analysis of a design), and of each item from the others that the same people answered.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from tactogram.statistics import holm, nan_mean, paired_equivalence, pseudomedian, signed_rank_p, summary
from tactogram_study.analysis.findings import AnalysisSection, Finding, Role, numeric_answers, section_of
from tactogram_study.answers import Answers

Numbers = NDArray[np.float64]


def paired_findings(
    differences: Numbers,
    of: str,
    measure: str,
    *,
    margin: float | None = None,
    n: int,
    roles: tuple[Role, Role] = ("check", "check"),
    ps: tuple[float, float] | None = None,
    equivalence_p: float | None = None,
) -> list[Finding]:
    """Return the paired t-test with interval, Cohen's dz and equivalence, and Wilcoxon's, of ``n`` answers.

    ``roles`` are those of the t-test and of Wilcoxon's; ``ps`` and ``equivalence_p`` replace their p and that of the
    test of equivalence after Holm's correction.
    """
    estimate = summary(differences)
    p, rank_p = ps or paired_ps(differences)
    equal = equivalence_p
    if equal is None and margin is not None:
        equal = paired_equivalence(differences, margin=margin)
    shared: dict[str, Any] = {
        "n": n,
        "participants": len(differences),
        "equivalence_p": equal,
        "margin": margin,
        "correction": "Holm" if ps else "none",
    }
    mean = (estimate.mean, estimate.low, estimate.high, p)
    size = {"dz": estimate.mean / estimate.sd} if estimate.sd > 0 else {}
    statistic = estimate.mean / estimate.se if estimate.se > 0 else None
    test, rank_test = "paired t by participant", "Wilcoxon signed ranks by participant, Hodges-Lehmann"
    middle = (*pseudomedian(differences), rank_p)
    note = "" if margin is None else "equivalence is by paired t"
    return [
        Finding(of, test, roles[0], measure, *mean, statistic=statistic, effect=size, **shared),
        Finding(of, rank_test, roles[1], f"pseudomedian of {measure}", *middle, note=note, **shared),
    ]


def mean_finding(
    values: Numbers, of: str, test: str, role: Role, measure: str, *, n: int, **more: Any
) -> Finding:
    """Return the mean of one value of each participant, with its interval by Student's t.

    Of a single participant there is no interval, and ``more``, further values of the `Finding`, do not hold.
    """
    estimate = summary(values)
    if estimate.n == 1:
        note = "one participant: no interval over people"
        return Finding(of, test, role, measure, estimate.mean, n=n, participants=1, note=note)
    interval = (estimate.mean, estimate.low, estimate.high)
    return Finding(of, test, role, measure, *interval, n=n, participants=estimate.n, **more)


def holm_paired(
    gaps: Mapping[str, tuple[Numbers, int]],
    measure: str,
    margin: float | None,
    roles: tuple[Role, Role] = ("check", "check"),
) -> list[Finding]:
    """Return the `paired_findings` of several comparisons, every p with Holm's correction over them.

    ``gaps`` holds, by comparison, the participants' differences and the number of answers.
    """
    both = [paired_ps(differences) for differences, _ in gaps.values()]
    t_p, rank_p = (holm([pair[k] for pair in both]) for k in (0, 1))
    equal: list[float | None] = [None] * len(gaps)
    if margin is not None:
        equal = [*holm([paired_equivalence(d, margin=margin) for d, _ in gaps.values()])]
    return [
        finding
        for (of, (differences, n)), t, rank, e in zip(gaps.items(), t_p, rank_p, equal, strict=True)
        for finding in paired_findings(
            differences, of, measure, margin=margin, n=n, roles=roles, ps=(t, rank), equivalence_p=e
        )
    ]


def paired_ps(differences: Numbers) -> tuple[float, float]:
    """Return p of Student's t and of Wilcoxon's signed ranks of differences against 0."""
    if not differences.any():
        return 1.0, 1.0
    estimate = summary(differences)
    # Differences without spread: t is infinite, as it should be.
    t = abs(estimate.mean) / estimate.se if estimate.se > 0 else np.inf
    return float(2 * stats.t.sf(t, estimate.n - 1)), signed_rank_p(differences)


def analyse_means(answers: Answers, *, title: str, margin: float | None = None) -> AnalysisSection:
    """Return the mean of each stimulus and condition over participants, and the differences between conditions.

    Confirmatory are the differences, each participant's mean over stimuli paired: Student's t with Holm's correction
    over the pairs of conditions. Raises `DataError` if no answer is a number.
    """
    kept, notes = numeric_answers(answers, title)
    rows: list[dict[str, Any]] = []
    for (stimulus, condition), means in kept.participant_means("stimulus", "condition").items():
        estimate = summary(means)
        single = estimate.n == 1
        rows.append(
            {
                "stimulus": stimulus,
                "condition": condition,
                "mean": estimate.mean,
                "low": None if single else estimate.low,
                "high": None if single else estimate.high,
                "participants": estimate.n,
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
    findings = holm_paired(
        {
            f"{item} {REST}, {WHOLE}": (people, counts[item])
            for item, people in whole.items()
            if len(people) > 1
        },
        measure,
        margin,
    )
    if not per_word:
        return findings
    single = {
        f"{item} {REST}, {word}": (gaps[:, i, w][~np.isnan(gaps[:, i, w])], counts[item] // len(words))
        for i, item in enumerate(items)
        for w, word in enumerate(words)
    }
    kept = {of: gap for of, gap in single.items() if len(gap[0]) > 1}
    return findings + holm_paired(kept, measure, margin)


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
