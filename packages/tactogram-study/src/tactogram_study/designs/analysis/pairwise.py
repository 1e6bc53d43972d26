"""Analysis and power of preferences: strengths of R. A. Bradley, M. E. Terry, Biometrika 39 (1952), by participant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import special, stats

from tactogram.errors import DataError, ParameterError
from tactogram.statistics import BLUE, GRAY, holm, holm_rows
from tactogram_study.analysis.figures import title_of
from tactogram_study.analysis.findings import (
    AnalysisSection,
    Finding,
    exact_finding,
    numeric_answers,
    section_of,
)
from tactogram_study.answers import Answer, Answers
from tactogram_study.designs.pairwise import (
    LEAST,
    PRIOR_SD,
    bradley_terry,
    curvature,
    gap_errors,
    strengths_by_participant,
)
from tactogram_study.planned import PowerAssumptions
from tactogram_study.power import PowerMethod, StudyBatch, Truths
from tactogram_study.statistics import share_of

Numbers = NDArray[np.float64]
TEST = "Bradley-Terry by participant"
APART = "never compared, not even through others: not tested"
ALIKE = "all participants say the same of the two: error as of independent answers"


def analyse_preference(answers: Answers, *, margin: float | None = None) -> AnalysisSection:
    """Return the strength of each item, and the preference in each pair.

    Confirmatory are the differences of strengths by participant (`strengths_by_participant`), Student's t with
    participants - 1 degrees of freedom, and Holm's correction over all pairs; with two items this is the share that
    prefers the first. Intervals, p and equivalence rest on one standard error. Two items that were never compared, not
    even through others, are not tested: their difference follows from the prior alone.

    ``stimulus`` (with ``condition``) and ``other`` (with ``other_condition``) are the pair; ``value`` is 1 where
    ``stimulus`` was preferred, 0 where ``other`` was, 0.5 for a tie. The margin is one of log strengths: 0.4 is 60 %
    who prefer the first. Raises `DataError` for another value, fewer than two items, or a pair of one item.
    """
    kept, notes = numeric_answers(answers, "pairwise")
    pairs = [(_item(row.stimulus, row.condition), _item(row.other, _other(row))) for row in kept]
    items = tuple(dict.fromkeys(name for pair in pairs for name in pair))
    if len(items) < 2 or any(a == b for a, b in pairs):
        raise DataError(f"pairwise: must be pairs of two items, got {', '.join(items)}")
    if any(value not in (0.0, 0.5, 1.0) for value in kept.numbers()):
        raise DataError(
            "pairwise: value must be 1 (stimulus preferred), 0 (other) or 0.5, got another number"
        )
    people = kept.unique("participant")
    table = np.zeros((len(people), len(items), len(items)))
    for row, (first, second) in zip(kept, pairs, strict=True):
        who, a, b = people.index(row.participant), items.index(first), items.index(second)
        table[who, a, b] += row.value
        table[who, b, a] += 1 - row.value
    if len(people) > 1:
        strengths, covariance = strengths_by_participant(table)
    else:
        strengths, covariance = bradley_terry(table.sum(0)), np.full((len(items), len(items)), np.nan)
    rows = _rows(items, table, strengths, covariance)
    findings = _pairs(items, table, strengths, covariance, margin)
    if len(people) == 1:
        notes += ("one participant: no interval over people",)
    if _components(table.sum(0)).any():
        notes += (
            "some items were never compared, not even through others: their strengths rest on the prior",
        )
    notes += (f"strengths have a weak prior (SD {PRIOR_SD:g}), so that what always wins stays finite",)
    return section_of(kept, "Preference", findings, {"strengths (log, mean 0)": rows}, notes)


def _item(stimulus: str, condition: str) -> str:
    return f"{stimulus} ({condition})" if condition else stimulus


def _other(row: Answer) -> str:
    return row.more.get("other_condition", row.condition if row.other != row.stimulus else "")


def _rows(
    items: Sequence[str], table: Numbers, strengths: Numbers, covariance: Numbers
) -> list[dict[str, Any]]:
    wins = table.sum(0)
    middle = np.eye(len(items)) - 1 / len(items)
    alone = np.diag(middle @ np.linalg.inv(curvature(wins, strengths)) @ middle)
    variances = np.diag(covariance)
    halves = _t95(len(table)) * np.sqrt(np.where(variances < LEAST**2, alone, variances))
    order = np.argsort(-strengths, kind="stable")
    return [
        {
            "item": items[k],
            "strength": float(strengths[k]),
            "low": float(strengths[k] - halves[k]),
            "high": float(strengths[k] + halves[k]),
            "preferred": float(wins[k].sum()),
            "of": float(wins[k].sum() + wins[:, k].sum()),
        }
        for k in order
    ]


def _t95(people: int) -> float:
    return float(stats.t.isf(0.025, people - 1)) if people > 1 else float("nan")


def _pairs(
    items: Sequence[str], table: Numbers, strengths: Numbers, covariance: Numbers, margin: float | None
) -> list[Finding]:
    """Return the difference of strengths of each pair, and the exact binomial of its own comparisons."""
    names = list(combinations(range(len(items)), 2))
    wins, people = table.sum(0), len(table)
    first, second = (np.array([pair[k] for pair in names]) for k in (0, 1))
    gaps = strengths[first] - strengths[second]
    part = _components(wins)
    notes = [APART if part[a] != part[b] else "" for a, b in names]
    tested = [k for k, note in enumerate(notes) if not note] if people > 1 else []
    ps: list[float | None] = [None] * len(names)
    equals = list(ps)
    halves = np.full(len(names), np.nan)
    if tested:
        se, alike = gap_errors(covariance, curvature(wins, strengths), first[tested], second[tested])
        far = np.abs(gaps[tested])
        halves[tested] = _t95(people) * se
        shown = holm(2 * stats.t.sf(far / se, people - 1))
        equal_ps: list[float | None] = [None] * len(tested)
        if margin is not None:
            equal_ps = [*holm(stats.t.sf((margin - far) / se, people - 1))]
        for k, p, equal, same in zip(tested, shown, equal_ps, alike, strict=True):
            ps[k], equals[k], notes[k] = p, equal, ALIKE if same else ""
    findings = []
    for (a, b), gap, half, p, equal, note in zip(
        names, gaps.tolist(), halves.tolist(), ps, equals, notes, strict=True
    ):
        name = f"{items[a]} over {items[b]}"
        findings.append(
            Finding(
                name,
                TEST,
                "confirmatory",
                "difference of log strengths",
                gap,
                None if p is None else gap - half,
                None if p is None else gap + half,
                p,
                n=int(wins.sum()),
                participants=people,
                effect={"P(first preferred)": float(special.expit(gap))},
                equivalence_p=equal,
                margin=None if equal is None else margin,
                correction="Holm",
                note=note,
            )
        )
        direct = int(wins[a, b] + wins[b, a])
        if direct:
            share = share_of(int(np.floor(wins[a, b])), direct)
            findings.append(
                exact_finding(
                    name,
                    share,
                    "share preferring the first",
                    test="exact binomial of this pair alone, uncorrected",
                    participants=people,
                    note="takes answers as independent",
                )
            )
    return findings


def _components(wins: Numbers) -> NDArray[np.int64]:
    """Return the component of each item: those that were compared, directly or through others."""
    from scipy.sparse.csgraph import connected_components

    return np.asarray(connected_components(wins + wins.T, directed=False)[1], np.int64)


def preference_figure(section: AnalysisSection) -> Figure:
    """Draw the strength of each item with its interval, the most preferred on top."""
    rows = next(iter(section.tables.values()))
    figure = Figure(figsize=(6.4, 1.4 + 0.36 * max(3, len(rows))), layout="constrained")
    axes = figure.add_subplot()
    y = np.arange(len(rows))
    strengths = np.array([row["strength"] for row in rows])
    ends = np.array([[row["low"], row["high"]] for row in rows], float)
    axes.errorbar(
        strengths, y, xerr=np.nan_to_num(np.abs(ends - strengths[:, None])).T, fmt="o", color=BLUE, capsize=3
    )
    axes.set_yticks(y, [str(row["item"]) for row in rows])
    axes.invert_yaxis()
    axes.axvline(0, color=GRAY, lw=0.8)
    axes.set_xlabel("log strength, mean 0 (95 % by participant)")
    axes.set_title(title_of(section), fontsize=10)
    return figure


AT_ONCE = 400_000
"""Numbers in the tables of a batch of studies: as many as fit a processor's cache."""


class Strengths(PowerMethod):
    """Strengths of items by participant, with Holm's correction over all pairs."""

    of_pairs = True

    def shares(self, rng: np.random.Generator, batch: StudyBatch, truths: Truths) -> dict[str, float]:
        """Return power of pairs that differ; for ``type_1`` that any pair is shown, and equivalence."""
        shares: dict[str, float] = {}
        assumed = batch.assumed
        for name, truth in truths.items():
            parts = [
                shown_and_equal(gaps, errors, people=batch.people, margin=assumed.margin, alpha=batch.alpha)
                for gaps, errors in simulated_preferences(
                    batch.people,
                    batch.trials,
                    items=assumed.items,
                    effect=truth,
                    person_sd=assumed.person_sd,
                    studies=batch.simulations,
                    rng=rng,
                )
            ]
            shown, equal = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
            if name == "power":
                shares[name] = float(shown[:, : assumed.items - 1].mean())
            else:
                shares[name] = float(shown.any(1).mean())
                shares["equivalence"] = float(equal.mean())
                shares["all_equivalent"] = float(equal.all(1).mean())
        return shares

    def check(self, assumed: PowerAssumptions) -> None:
        """Raise `ParameterError` for too few or too many items."""
        if not 2 <= assumed.items <= 100:
            raise ParameterError.must("items", "be from 2 to 100", assumed.items)

    def notes(self) -> list[str]:
        return [
            "power: of a pair that differs; type_1: that any pair is shown where none differs; equivalence: of a pair, "
            "all_equivalent: of all pairs at once."
        ]


def simulated_preferences(
    people: int,
    comparisons: int,
    *,
    items: int,
    effect: float,
    person_sd: float,
    studies: int,
    rng: np.random.Generator,
) -> Iterator[tuple[Numbers, Numbers]]:
    """Yield, in batches of studies, each pair's difference of log strengths and its standard error.

    Both are of shape (study, pair); the first ``items - 1`` pairs are those of the first item, whose log strength is
    larger by ``effect``. Pairs are presented as equally often as the number of comparisons allows: with equal items,
    the choice of the most informative pair comes to the same.
    """
    pairs = np.array(list(combinations(range(items), 2)))
    first, second = pairs.T
    each, rest = divmod(comparisons, len(pairs))
    batch = max(1, AT_ONCE // (people * items**2))
    for begin in range(0, studies, batch):
        count = min(batch, studies - begin)
        strengths = person_sd * rng.standard_normal((count, people, items))
        strengths[..., 0] += effect
        order = np.argsort(rng.random((count, people, len(pairs))), axis=-1)
        asked = each + (order < rest)
        won = rng.binomial(asked, special.expit(strengths[..., first] - strengths[..., second]))
        tables = np.zeros((count, people, items, items))
        tables[..., first, second], tables[..., second, first] = won, asked - won
        estimated, covariance = strengths_by_participant(tables)
        errors, _ = gap_errors(covariance, curvature(tables.sum(1), estimated), first, second)
        yield estimated[:, first] - estimated[:, second], errors


def shown_and_equal(
    gaps: Numbers, errors: Numbers, *, people: int, margin: float, alpha: float
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which pairs are shown to differ, and which to be within the margin, each with Holm's correction.

    As `analyse_preference`, for many studies: all arrays are of shape (study, pair).
    """
    far = np.abs(gaps)
    shown = holm_rows(2 * stats.t.sf(far / errors, people - 1)) < alpha
    equal = holm_rows(stats.t.sf((margin - far) / errors, people - 1)) < alpha
    return shown, equal & ~shown
