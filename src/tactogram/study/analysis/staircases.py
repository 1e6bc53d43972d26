"""Staircases: each participant's threshold by reversals and by a psychometric function, and that of people."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.statistics.summary import summary
from tactogram.study.analysis.finding import Finding, Section, answered
from tactogram.study.analysis.realism import paired_findings
from tactogram.study.answers import Answers
from tactogram.study.psychometric import (
    PsychometricFit,
    Shape,
    fit_psychometric,
    reversal_threshold,
)


def analyse_staircases(
    answers: Answers,
    *,
    rng: np.random.Generator,
    margin: float | None = None,
    shape: Shape = "logistic",
    guess: float = 0.5,
    target: float = 0.75,
    draws: int = 200,
    unit: str = "dB",
) -> Section:
    """Return thresholds of two-alternative staircases, by participant and over all.

    Confirmatory is the mean over participants of the thresholds by reversals, with an interval by Student's t; between
    two staircases the paired difference.

    Parameters
    ----------
    answers : Answers
        ``value`` is the intensity, ``correct`` the outcome, ``condition`` the staircase, in the order of ``trial``.
    rng : numpy Generator
        For the bootstrap.
    margin : float, optional
        Of a difference between two staircases, in their unit.
    shape : {"logistic", "gaussian", "weibull"}
        Over intensities as they are: decibels are logarithms already, so that logistic is the default.
    guess, target : float
    draws : int
    unit : str

    Raises
    ------
    DataError
        If no answer has both a number and an outcome, or no threshold could be had.
    """
    kept, notes = answered(answers.where(lambda row: row.correct is not None), "staircase")
    curves: dict[tuple[str, str], PsychometricFit] = {}
    turned: dict[tuple[str, str], float] = {}
    rows: list[dict[str, Any]] = []
    for staircase, group in kept.by("condition").items():
        for person, own in group.by("participant").items():
            row = _own(staircase, person, own, shape, guess, target, rng, draws, curves, turned)
            rows.append(row)
    if not turned and not curves:
        raise DataError(
            "staircase: must have reversals, or right and wrong answers at two intensities; no threshold could be had"
        )
    names = kept.unique("condition")
    findings = []
    for role, held, how in (
        ("confirmatory", turned, "mean of reversals, Student's t over participants"),
        (
            "check",
            {key: fit.threshold for key, fit in curves.items()},
            f"{shape} fits at {target:g}, Student's t",
        ),
    ):
        for name in names:
            values = np.array([value for (staircase, _), value in held.items() if staircase == name])
            if len(values):
                findings.append(_mean(values, name, role, how, unit, kept))
        findings += _between(held, names, role, unit, margin, len(kept))
    findings += [
        _pooled(name, kept, shape, guess, target, rng, draws, unit) for name in names if _fits(kept, name)
    ]
    outside = sum(not fit.inside for fit in curves.values())
    notes += (f"{outside} fitted thresholds lie outside the intensities that were shown",) if outside else ()
    notes += (
        "reversals of 1 up n down settle where p**n = 1/2 (.707 of 2 down, .794 of 3 down), "
        f"the fits are read at {target:g}",
    )
    if lost := len(rows) - len(turned):
        notes += (f"{lost} staircases had too few reversals for a threshold",)
    return Section(
        "Staircases",
        kept.rows[0].design,
        kept.rows[0].question,
        len(set(kept.column("participant"))),
        len(kept),
        any(kept.column("simulated")),
        tuple(findings),
        {f"thresholds, {unit}": rows},
        notes,
    )


def reversals_of(own: Answers) -> NDArray[np.bool_]:
    """Return which trials of one staircase turned it, bool, shape (trial,).

    From the column ``reversal`` (true), else from ``reversals`` (how many there were before the trial), else from the
    steps of the intensity. Of these two the last trial's follows from what made the staircase turn before.
    """
    if "reversal" in own.further:
        return np.array([text.casefold() in ("true", "1") for text in own.column("reversal")])
    values = own.numbers("value")
    last = _ends_turning(values, own.numbers("correct"))
    if "reversals" in own.further and all(own.column("reversals")):
        before = np.array([int(text) for text in own.column("reversals")])
        return np.append(np.diff(before) > 0, last)
    turned = np.zeros(len(values), bool)
    heading = 0.0
    for trial, step in enumerate(np.sign(np.diff(values))):
        if step:
            turned[trial] = bool(heading) and step != heading
            heading = step
    turned[-1] = last
    return turned


def _ends_turning(values: NDArray[np.float64], right: NDArray[np.float64]) -> bool:
    """Return whether the last answer turned the staircase: against its heading, after as many as moved it before."""
    steps = np.sign(np.diff(values))
    moves = np.flatnonzero(steps).tolist()
    direction = -1 if right[-1] else 1
    if not moves or steps[moves[-1]] == direction:
        return False
    starts = dict(zip(moves, [0, *(move + 1 for move in moves[:-1])], strict=True))
    needed = [_run(right[starts[move] : move + 1]) for move in moves if steps[move] == direction]
    return bool(needed) and _run(right[moves[-1] + 1 :]) >= min(needed)


def _run(right: NDArray[np.float64]) -> int:
    """Return how many answers at the end were alike."""
    other = np.flatnonzero(right != right[-1])
    return len(right) - (int(other[-1]) + 1 if len(other) else 0)


def in_order(own: Answers) -> Answers:
    """Return the answers of one participant in the order of their trials."""
    return Answers(tuple(sorted(own.rows, key=lambda row: (row.session, row.trial))))


def _own(
    staircase: str,
    person: str,
    own: Answers,
    shape: Shape,
    guess: float,
    target: float,
    rng: np.random.Generator,
    draws: int,
    curves: dict[tuple[str, str], PsychometricFit],
    turned: dict[tuple[str, str], float],
) -> dict[str, Any]:
    own = in_order(own)
    values, right = own.numbers("value"), own.numbers("correct")
    marks = reversals_of(own)
    threshold = reversal_threshold(values, marks.tolist())
    if threshold is not None:
        turned[staircase, person] = threshold
    row: dict[str, Any] = {
        "staircase": staircase,
        "participant": person,
        "trials": len(own),
        "reversals": int(marks.sum()),
        "by_reversals": threshold,
    }
    try:
        fit = fit_psychometric(values, right, rng=rng, shape=shape, guess=guess, target=target, draws=draws)
    except DataError:
        return row
    curves[staircase, person] = fit
    return row | {
        "fitted": fit.threshold,
        "fitted_low": fit.low,
        "fitted_high": fit.high,
        "slope": fit.slope,
        "lapse": fit.lapse,
        "deviance_p": fit.deviance_p,
        "inside": str(fit.inside).lower(),
    }


def _mean(values: NDArray[np.float64], name: str, role: Any, how: str, unit: str, kept: Answers) -> Finding:
    found = summary(values)
    one = len(values) == 1
    return Finding(
        name,
        how,
        role,
        f"threshold, {unit}",
        found.mean,
        None if one else found.low,
        None if one else found.high,
        n=len(kept.where(condition=name)),
        participants=len(values),
        note="one participant: no interval over people" if one else "",
    )


def _between(
    held: dict[tuple[str, str], float],
    names: tuple[str, ...],
    role: Any,
    unit: str,
    margin: float | None,
    n: int,
) -> list[Finding]:
    """Return the paired difference of two staircases."""
    if len(names) != 2:
        return []
    people = [p for staircase, p in held if staircase == names[0] and (names[1], p) in held]
    if len(people) < 2:
        return []
    gaps = np.array([held[names[0], p] - held[names[1], p] for p in people])
    return paired_findings(
        gaps, "all", f"{names[0]} minus {names[1]}, {unit}", margin=margin, n=n, roles=(role, "check")
    )


def _fits(kept: Answers, name: str) -> bool:
    group = kept.where(condition=name)
    return len(set(group.column("value"))) > 1 and len(set(group.column("correct"))) > 1


def _pooled(
    name: str,
    kept: Answers,
    shape: Shape,
    guess: float,
    target: float,
    rng: np.random.Generator,
    draws: int,
    unit: str,
) -> Finding:
    """Return the function of all answers together, its interval by participants drawn with replacement."""
    groups = [in_order(own) for own in kept.where(condition=name).by("participant").values()]
    data = [(own.numbers("value"), own.numbers("correct")) for own in groups]

    def threshold(which: NDArray[np.int64]) -> float:
        x, y = (np.concatenate([data[k][part] for k in which]) for part in (0, 1))
        fit = fit_psychometric(x, y, rng=rng, shape=shape, guess=guess, target=target, draws=0)
        return fit.threshold

    whole = threshold(np.arange(len(data)))
    drawn = []
    for _ in range(draws if len(data) > 1 else 0):
        try:
            drawn.append(threshold(rng.integers(0, len(data), len(data))))
        except DataError:
            continue
    low, high = np.quantile(drawn, [0.025, 0.975]) if drawn else (np.nan, np.nan)
    return Finding(
        name,
        f"one {shape} function of all answers, bootstrap by participant",
        "check",
        f"threshold at {target:g}, {unit}",
        whole,
        float(low) if drawn else None,
        float(high) if drawn else None,
        n=sum(len(x) for x, _ in data),
        participants=len(data),
        note="flatter than one person's where thresholds of people differ",
    )
