"""Analysis of word scores: errors to target scores, by condition and word, by participant and as published.

The publications print the mean absolute error of all scores with its standard error (n = 2,400), Student's t [1, Fig.
7] and Steel-Dwass [2, Fig. 5 and 6]. Both take each score as independent, which the 120 of one person are not. Here:
each participant's mean error, Friedman and Wilcoxon's signed ranks, intervals by bootstrap over participants.

[1], [2] as in `tactogram.datasets.ratings.words`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.datasets import WORDS
from tactogram.errors import DataError
from tactogram.signal import AXIS_COLOURS
from tactogram.statistics import (
    GRAY,
    INDEPENDENT,
    Comparison,
    error_figure,
    friedman_wilcoxon,
    holm,
    nan_mean,
    steel_dwass,
    student_t,
)
from tactogram_study.analysis.figures import title_of
from tactogram_study.analysis.findings import (
    SHOWN,
    AnalysisSection,
    Finding,
    Role,
    numeric_answers,
    section_of,
)
from tactogram_study.analysis.paired import holm_paired, item_contrasts
from tactogram_study.answers import Answer, Answers, Targets
from tactogram_study.statistics import bootstrap_by_participant

Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class AnswerErrors:
    """Errors of answers, or the scores without targets.

    ``values`` by condition and word have shape (answer,); ``people``, the means of each participant, have shape
    (participant, condition, word), with NaN where there is none.
    """

    conditions: tuple[str, ...]
    words: tuple[str, ...]
    participants: tuple[str, ...]
    values: Mapping[tuple[str, str], Numbers]
    people: Numbers
    measure: str

    def of(self, condition: str) -> Numbers:
        """Return all errors in a condition."""
        return np.concatenate(list(self.by_word(condition).values()))

    def by_word(self, condition: str) -> dict[str, Numbers]:
        """Return the errors in a condition by word."""
        return {word: self.values[condition, word] for word in self.words if (condition, word) in self.values}

    @property
    def difference(self) -> str:
        """Measure of a difference between conditions."""
        return f"difference of {self.measure}"


def analyse_words(
    answers: Answers,
    *,
    rng: np.random.Generator,
    targets: Targets | None = None,
    reference: str | None = None,
    margin: float | None = None,
    draws: int = 2000,
) -> AnalysisSection:
    """Return the analysis of scores (``value``) of words (``question``) of items by condition.

    Confirmatory is Friedman's test over the conditions, of two Wilcoxon's signed ranks, on each participant's mean over
    words, and between every two conditions Wilcoxon's with Holm's correction. With one condition each item is compared
    with the mean of the others, by participant.

    With ``targets``, or the mean scores of a condition as ``reference``, errors are analysed instead of scores. The
    margin is one of the mean absolute error (or score), in points, set before the answers were seen. Raises `DataError`
    if no answer is a number, the reference is no condition, or a stimulus or word has no target.
    """
    kept, notes = numeric_answers(answers, "rating")
    if reference is not None:
        kept, targets = _reference_targets(kept, reference)
    errors = errors_of(kept, targets)
    rows, overall = _table(errors, rng, draws)
    findings = _by_participant(errors, margin) + _printed(errors) + _per_word(errors, margin)
    if len(errors.conditions) > 1:
        notes += (f"what was printed {INDEPENDENT}",)
    else:
        notes += ("one condition: items are held against each other, and nothing is confirmatory",)
        if targets is None:
            findings += item_contrasts(kept, errors.difference, margin=margin, per_word=True)
    if targets is None:
        notes += ("no target scores were given: scores are compared, not their errors",)
    return section_of(
        kept,
        "Words" + (": mean absolute error" if targets else ": scores"),
        findings,
        {errors.measure: overall, f"{errors.measure}, per word": rows},
        notes,
        question="words",
    )


def errors_of(answers: Answers, targets: Targets | None) -> AnswerErrors:
    """Return the absolute errors of scores to their targets, or the scores without targets.

    Raises `DataError`, naming the first stimulus or word without a target.
    """
    if targets is not None:
        answers = Answers(
            tuple(replace(row, value=abs(row.value - _target(targets, row))) for row in answers)
        )
    conditions = tuple(sorted(answers.unique("condition"), key=_by_size))
    words = tuple(sorted(answers.unique("question"), key=_as_listed))
    people = answers.unique("participant")
    row_of = {name: number for number, name in enumerate(people)}
    means = np.full((len(people), len(conditions), len(words)), np.nan)
    for (person, condition, word), values in answers.values_by(
        "participant", "condition", "question"
    ).items():
        means[row_of[person], conditions.index(condition), words.index(word)] = np.mean(values)
    cells = {
        (c, w): np.array(values) for (c, w), values in answers.values_by("condition", "question").items()
    }
    measure = "score, points" if targets is None else "mean absolute error, points"
    return AnswerErrors(conditions, words, people, cells, means, measure)


def _by_size(name: str) -> tuple[float, str]:
    """Return the sort key of conditions: names first, then numbers by size."""
    try:
        return float(name.replace(",", "")), name
    except ValueError:
        return -math.inf, name


def _as_listed(word: str) -> tuple[int, str]:
    """Return the sort key of words: the ten words as the publications list them, then others by name."""
    return (WORDS.index(word), "") if word in WORDS else (len(WORDS), word)


def _target(targets: Targets, row: Answer) -> float:
    try:
        return float(targets[row.stimulus][row.question])
    except KeyError:
        raise DataError(
            f"targets: must have a score of {row.stimulus!r} for {row.question!r}, have {len(targets)} stimuli "
            f"({', '.join(list(targets)[:5])})"
        ) from None


def _reference_targets(answers: Answers, reference: str) -> tuple[Answers, Targets]:
    """Return the answers of the other conditions, and the mean scores of the reference."""
    rated = answers.where(condition=reference)
    if not len(rated):
        conditions = ", ".join(answers.unique("condition"))
        raise DataError(f"reference must be one of the conditions {conditions}, got {reference!r}")
    targets: dict[str, dict[str, float]] = {}
    for (stimulus, word), values in rated.values_by("stimulus", "question").items():
        targets.setdefault(stimulus, {})[word] = float(np.mean(values))
    rest = answers.where(lambda row: row.condition != reference)
    if not len(rest):
        raise DataError(f"reference {reference!r} is the only condition: nothing is left to compare with it")
    return rest, targets


def _by_participant(errors: AnswerErrors, margin: float | None) -> list[Finding]:
    """Return the tests between conditions on each participant's mean over words."""
    if len(errors.conditions) < 2 or len(errors.participants) < 2:
        return []
    means = dict(zip(errors.conditions, nan_mean(errors.people, 2).T, strict=True))
    comparison = friedman_wilcoxon(means)
    findings = [_friedman(comparison, "all words", "confirmatory", errors)] if comparison.overall else []
    gaps = {}
    for first, second in combinations(errors.conditions, 2):
        apart = means[first] - means[second]
        count = len(errors.of(first)) + len(errors.of(second))
        gaps[f"{first} minus {second}"] = (apart[~np.isnan(apart)], count)
    return findings + holm_paired(gaps, errors.difference, margin, ("check", "confirmatory"))


def _friedman(
    comparison: Comparison, of: str, role: Role, errors: AnswerErrors, p: float | None = None
) -> Finding:
    statistic, raw = comparison.overall or (0.0, 1.0)
    means = [group.mean for group in comparison.groups.values()]
    p = raw if p is None else p
    return Finding(
        of,
        f"Friedman over {len(means)} conditions",
        role,
        f"largest {errors.difference}",
        max(means) - min(means),
        p=p,
        participants=len(errors.participants) - comparison.left_out,
        n=sum(len(values) for values in errors.values.values()),
        statistic=statistic,
        correction="none" if of == "all words" else "Holm over words",
    )


def _printed(errors: AnswerErrors) -> list[Finding]:
    """Return Student's t and Steel-Dwass on every score, over all words and per word."""
    if len(errors.conditions) < 2:
        return []
    findings = []
    flat = {name: errors.of(name) for name in errors.conditions}
    per_word = {
        word: {c: errors.values[c, word] for c in errors.conditions if (c, word) in errors.values}
        for word in errors.words
    }
    tests = [("all words", student_t(flat)), ("all words", steel_dwass(flat))]
    tests += [
        (word, steel_dwass(groups))
        for word, groups in per_word.items()
        if len(groups) > 1 and min(len(values) for values in groups.values()) > 1
    ]
    for of, test in tests:
        findings += [
            Finding(
                f"{of}, {pair.first} minus {pair.second}",
                test.test,
                "as printed",
                errors.difference,
                pair.difference,
                p=pair.p,
                n=test.groups[pair.first].n + test.groups[pair.second].n,
                participants=len(errors.participants),
                statistic=pair.statistic,
                correction=test.correction,
            )
            for pair in test.pairs
        ]
    return findings


def _per_word(errors: AnswerErrors, margin: float | None) -> list[Finding]:
    """Return Friedman and paired tests per word; p by Holm over words, and over words and pairs."""
    if len(errors.conditions) < 2:
        return []
    friedmans: dict[str, Comparison] = {}
    gaps: dict[str, tuple[Numbers, int]] = {}
    for index, word in enumerate(errors.words):
        full = errors.people[:, :, index]
        full = full[~np.isnan(full).any(1)]
        if len(full) < 2:
            continue
        if len(errors.conditions) > 2:
            friedmans[word] = friedman_wilcoxon(dict(zip(errors.conditions, full.T, strict=True)))
        for a, b in combinations(range(len(errors.conditions)), 2):
            first, second = errors.conditions[a], errors.conditions[b]
            count = len(errors.values[first, word]) + len(errors.values[second, word])
            gaps[f"{word}, {first} minus {second}"] = (full[:, a] - full[:, b], count)
    findings = []
    overall = holm([test.overall[1] if test.overall else 1.0 for test in friedmans.values()])
    for (word, test), p in zip(friedmans.items(), overall, strict=True):
        findings.append(_friedman(test, word, "check", errors, p))
    if gaps:
        findings += holm_paired(gaps, errors.difference, margin)
    return findings


def _table(
    errors: AnswerErrors, rng: np.random.Generator, draws: int
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    words = bootstrap_by_participant(errors.people, lambda t: nan_mean(t, 0), rng=rng, draws=draws)
    whole = bootstrap_by_participant(
        errors.people, lambda t: nan_mean(nan_mean(t, 2), 0), rng=rng, draws=draws
    )
    rows, overall = [], []
    for c, condition in enumerate(errors.conditions):
        values = errors.of(condition)
        people = int((~np.isnan(errors.people[:, c]).all(1)).sum())
        facts = {"condition": condition, "n": len(values), "participants": people}
        overall.append(facts | _interval(whole, c, values))
        for word, values in errors.by_word(condition).items():
            cell = c, errors.words.index(word)
            facts = {"condition": condition, "word": word, "n": len(values)}
            rows.append(facts | _interval(words, cell, values))
    return rows, overall


def _interval(bootstrapped: tuple[Numbers, ...], index: Any, values: Numbers) -> dict[str, Any]:
    """Return the columns of a mean with its interval, and its standard error as printed."""
    mean, low, high = (float(part[index]) for part in bootstrapped)
    se = float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else None
    return {"mean": mean, "low": low, "high": high, "se_as_printed": se}


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
        positions = np.arange(len(words)) + width * (k - (len(conditions) - 1) / 2)
        away = np.nan_to_num(np.abs(table[:, 1:] - table[:, :1]).T)
        axes.bar(
            positions, table[:, 0], 0.92 * width, yerr=away, color=colours[k % len(colours)], label=condition,
            error_kw={"lw": 0.8}, capsize=1.5,
        )  # fmt: skip
    axes.set_xticks(range(len(words)), words, rotation=25)
    axes.set_ylabel(f"{name.removesuffix(', per word')}\n(95 % by participant)")
    axes.set_ylim(bottom=0)
    axes.set_title(title_of(section), fontsize=10)
    if any(conditions):  # one condition may have no name
        figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    return figure
