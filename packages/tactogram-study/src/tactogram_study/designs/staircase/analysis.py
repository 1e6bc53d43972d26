"""Analysis of staircases: thresholds by psychometric functions and by reversals, of each participant and over all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.errors import DataError
from tactogram.signal import AXIS_COLOURS
from tactogram.statistics import GRAY, INK, summary
from tactogram_study.analysis.figures import title_of
from tactogram_study.analysis.findings import AnalysisSection, Finding, Role, numeric_answers, section_of
from tactogram_study.analysis.paired import paired_findings
from tactogram_study.analysis.threshold import (
    SETTLED_3_DOWN,
    Threshold,
    estimate_threshold,
    reversal_threshold,
    settled_share,
)
from tactogram_study.answers import Answers
from tactogram_study.designs.staircase.reversals import in_order, reversals_of

ENOUGH_REVERSALS = 12
"""With fewer, the bias exceeds 0.3 dB where the function is as flat as four steps (docs/studies.md)."""
FITTED = "logistic fits of each participant, Student's t"


def analyse_staircases(
    answers: Answers,
    *,
    margin: float | None = None,
    guess: float = 0.5,
    share: float | None = None,
) -> AnalysisSection:
    """Return thresholds of two-alternative staircases, by participant and over all.

    Confirmatory is the mean over participants of the thresholds of `estimate_threshold`, with an interval by Student's
    t; between two staircases the paired difference. Means of reversals are a check: they err more, and are higher the
    fewer there are.

    ``value`` is the intensity in dB, ``correct`` the outcome, ``condition`` the staircase, in the order of ``trial``.
    ``guess`` is the share correct without any signal, ``share`` that at the threshold: by default where the staircases
    settle by their rule (`settled_share`), .794 if the rule is unknown. Raises `DataError` if no threshold can be
    estimated.
    """
    kept, notes = numeric_answers(answers.where(lambda row: row.correct is not None), "staircase")
    tracks = {
        (staircase, person): in_order(own)
        for staircase, group in kept.by("condition").items()
        for person, own in group.by("participant").items()
    }
    share = share or _settled(tracks)
    fits = {key: fit for key, own in tracks.items() if (fit := _fit(own, share, guess)) is not None}
    means = {
        key: reversal_threshold(own.numbers("value"), reversals_of(own).tolist())
        for key, own in tracks.items()
    }
    turned = {key: mean for key, mean in means.items() if mean is not None}
    if not turned and not fits:
        raise DataError(
            "staircase: must have reversals, or right and wrong answers at two intensities; no threshold could be had"
        )
    names = kept.unique("condition")
    at = f"threshold at {share:.3f} correct, dB"
    findings: list[Finding] = []
    estimates: tuple[tuple[Role, dict[tuple[str, str], float], str, str], ...] = (
        ("confirmatory", {key: fit.threshold for key, fit in fits.items()}, FITTED, at),
        ("check", turned, "mean of reversals, Student's t over participants", "threshold, dB"),
    )
    for role, thresholds, test, measure in estimates:
        for name in names:
            values = np.array([value for (staircase, _), value in thresholds.items() if staircase == name])
            if len(values):
                findings.append(_mean(values, name, role, test, measure, kept))
        findings += _between(thresholds, names, role, margin, len(kept))
    return section_of(
        kept,
        "Staircases",
        findings,
        {"thresholds, dB": [_row(key, own, fits, turned) for key, own in tracks.items()]},
        (*notes, *_notes(tracks, fits, turned, share)),
    )


def _settled(tracks: Mapping[tuple[str, str], Answers]) -> float:
    """Return the share at which most staircases settle by their rule."""
    shares = [settled_share(own.numbers("value"), own.numbers("correct")) for own in tracks.values()]
    known = [share for share in shares if share is not None]
    return float(np.median(known)) if known else SETTLED_3_DOWN


def _fit(own: Answers, share: float, guess: float) -> Threshold | None:
    try:
        return estimate_threshold(own.numbers("value"), own.numbers("correct"), share=share, guess=guess)
    except DataError:
        return None


def _row(
    key: tuple[str, str],
    own: Answers,
    fits: Mapping[tuple[str, str], Threshold],
    turned: Mapping[tuple[str, str], float],
) -> dict[str, Any]:
    row: dict[str, Any] = {
        "staircase": key[0],
        "participant": key[1],
        "trials": len(own),
        "reversals": int(reversals_of(own).sum()),
        "by_reversals": turned.get(key),
    }
    if (fit := fits.get(key)) is None:
        return row
    return row | {
        "fitted": fit.threshold,
        "fitted_low": fit.low,
        "fitted_high": fit.high,
        "slope": fit.slope,
        "inside": str(fit.inside).lower(),
    }


def _notes(
    tracks: Mapping[tuple[str, str], Answers],
    fits: Mapping[tuple[str, str], Threshold],
    turned: Mapping[tuple[str, str], float],
    share: float,
) -> tuple[str, ...]:
    outside = sum(not fit.inside for fit in fits.values())
    few = sum(int(reversals_of(own).sum()) < ENOUGH_REVERSALS for own in tracks.values())
    counts = {
        f"{len(tracks) - len(fits)} staircases gave no fit": len(tracks) - len(fits),
        f"{outside} fitted thresholds lie outside the intensities that were shown": outside,
        f"{len(tracks) - len(turned)} staircases had too few reversals for a mean": len(tracks) - len(turned),
        f"{few} staircases have fewer than {ENOUGH_REVERSALS} reversals: where a function is flat they end before "
        "they settle, and thresholds come out high (docs/studies.md, Staircases)": few,
    }
    return (
        *(text for text, count in counts.items() if count),
        f"thresholds are read at {share:.3f} correct, where 1 up n down settles (p**n = 1/2: .707 of 2 down, .794 of "
        "3 down): read elsewhere they lean on a slope that so few trials do not know",
    )


def _mean(
    values: NDArray[np.float64], name: str, role: Role, test: str, measure: str, kept: Answers
) -> Finding:
    found = summary(values)
    single = len(values) == 1
    return Finding(
        name,
        test,
        role,
        measure,
        found.mean,
        None if single else found.low,
        None if single else found.high,
        n=len(kept.where(condition=name)),
        participants=len(values),
        note="one participant: no interval over people" if single else "",
    )


def _between(
    thresholds: dict[tuple[str, str], float],
    names: tuple[str, ...],
    role: Role,
    margin: float | None,
    n: int,
) -> list[Finding]:
    if len(names) != 2:
        return []
    people = [p for staircase, p in thresholds if staircase == names[0] and (names[1], p) in thresholds]
    if len(people) < 2:
        return []
    gaps = np.array([thresholds[names[0], p] - thresholds[names[1], p] for p in people])
    return paired_findings(
        gaps, "all", f"{names[0]} minus {names[1]}, dB", margin=margin, n=n, roles=(role, "check")
    )


def staircase_figure(section: AnalysisSection, answers: Answers) -> Figure:
    """Draw the tracks of each staircase with participants' thresholds, and the thresholds with their interval."""
    [(name, rows)] = section.tables.items()
    unit = name.rpartition(", ")[2]
    staircases = list(dict.fromkeys(str(row["staircase"]) for row in rows))
    figure = Figure(figsize=(9.5, 1.0 + 2.6 * len(staircases)), layout="constrained")
    grid = figure.subplots(len(staircases), 2, squeeze=False, width_ratios=(2, 1), sharey="row")
    for (left, right), staircase in zip(grid, staircases, strict=True):
        own = answers.where(condition=staircase)
        for k, (person, track) in enumerate(own.by("participant").items()):
            values = in_order(track).numbers("value")
            colour = AXIS_COLOURS[k % len(AXIS_COLOURS)]
            left.plot(range(1, len(values) + 1), values, lw=0.9, color=colour, alpha=0.8)
            row = next(r for r in rows if r["staircase"] == staircase and r["participant"] == person)
            if row["by_reversals"] is not None:
                right.plot([k], [row["by_reversals"]], "o", color=colour, ms=5)
            if row.get("fitted") is not None:
                ends = [
                    [max(0.0, row["fitted"] - row["fitted_low"])],
                    [max(0.0, row["fitted_high"] - row["fitted"])],
                ]
                right.errorbar([k + 0.2], [row["fitted"]], ends, fmt="_", color=colour, lw=1)
        whole = [f for f in section.role("confirmatory") if f.of == staircase]
        if whole:
            right.axhline(whole[0].estimate, color=INK, ls="--", lw=1)
            if whole[0].low is not None:
                right.axhspan(whole[0].low, whole[0].high, color=GRAY, alpha=0.18, lw=0)
        left.set(xlabel="trial", ylabel=f"{staircase}: intensity, {unit}")
        right.set(xlabel="participant\n(dot: reversals; bar: fit, 95 %)")
        right.set_xticks([])
    figure.suptitle(title_of(section), fontsize=10)
    return figure
