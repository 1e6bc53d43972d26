"""Analysis of staircases, and its power: thresholds by psychometric functions and by reversals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import special

from tactogram.errors import DataError
from tactogram.signal import AXIS_COLOURS
from tactogram.statistics import GRAY, INK
from tactogram_study.analysis.figures import title_of
from tactogram_study.analysis.findings import AnalysisSection, Finding, Role, numeric_answers, section_of
from tactogram_study.analysis.paired import mean_finding, paired_findings
from tactogram_study.analysis.threshold import (
    SETTLED_3_DOWN,
    Threshold,
    estimate_threshold,
    reversal_threshold,
    settled_share,
)
from tactogram_study.answers import Answers
from tactogram_study.designs.staircase import BELOW_START_DB
from tactogram_study.power import Means, StudyBatch


def reversals_of(own: Answers) -> NDArray[np.bool_]:
    """Return which trials of one staircase are reversals: bool, shape (trial,).

    From the column ``reversals`` (their number before the trial), else from the steps of the intensity. Whether the
    last trial is one follows from the rule of the earlier ones.
    """
    values = own.numbers("value")
    last = _ends_turning(values, own.numbers("correct"))
    if "reversals" in own.extra_columns and all(own.column("reversals")):
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
    """Return whether the last answer is a reversal: against the heading, after as many answers as earlier moves."""
    steps = np.sign(np.diff(values))
    moves = np.flatnonzero(steps).tolist()
    direction = -1 if right[-1] else 1
    if not moves or steps[moves[-1]] == direction:
        return False
    starts = dict(zip(moves, [0, *(move + 1 for move in moves[:-1])], strict=True))
    needed = [_run(right[starts[move] : move + 1]) for move in moves if steps[move] == direction]
    return bool(needed) and _run(right[moves[-1] + 1 :]) >= min(needed)


def _run(right: NDArray[np.float64]) -> int:
    """Return the number of equal answers at the end."""
    other = np.flatnonzero(right != right[-1])
    return len(right) - (int(other[-1]) + 1 if len(other) else 0)


def in_order(own: Answers) -> Answers:
    """Return the answers of one participant in the order of their trials."""
    return Answers(tuple(sorted(own.rows, key=lambda row: (row.session, row.trial))))


ENOUGH_REVERSALS = 12
"""With fewer, the bias exceeds 0.3 dB where the function is as flat as four steps (docs/studies.md)."""
FITTED = "logistic fits of each participant, Student's t"


def analyse_staircases(answers: Answers, *, margin: float | None = None) -> AnalysisSection:
    """Return thresholds of two-alternative staircases, by participant and over all.

    Confirmatory is the mean over participants of the thresholds of `estimate_threshold`, with an interval by Student's
    t; between two staircases the paired difference. Means of reversals are a check: they err more, and are higher the
    fewer there are.

    ``value`` is the intensity in dB, ``correct`` the outcome, ``condition`` the staircase, in the order of ``trial``.
    Thresholds are read where the staircases settle by their rule (`settled_share`), at .794 if the rule is unknown.
    Raises `DataError` if none can be estimated.
    """
    kept, notes = numeric_answers(answers.where(lambda row: row.correct is not None), "staircase")
    tracks = {
        (staircase, person): in_order(own)
        for staircase, group in kept.by("condition").items()
        for person, own in group.by("participant").items()
    }
    share = _settled(tracks)
    fits = {key: fit for key, own in tracks.items() if (fit := _fit(own, share)) is not None}
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
    label = f"threshold at {share:.3f} correct, dB"
    findings: list[Finding] = []
    estimates: tuple[tuple[Role, dict[tuple[str, str], float], str, str], ...] = (
        ("confirmatory", {key: fit.threshold for key, fit in fits.items()}, FITTED, label),
        ("check", turned, "mean of reversals, Student's t over participants", "threshold, dB"),
    )
    for role, thresholds, test, measure in estimates:
        for name in names:
            values = np.array([value for (staircase, _), value in thresholds.items() if staircase == name])
            if len(values):
                count = len(kept.where(condition=name))
                findings.append(mean_finding(values, name, test, role, measure, n=count))
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


def _fit(own: Answers, share: float) -> Threshold | None:
    try:
        return estimate_threshold(own.numbers("value"), own.numbers("correct"), share=share)
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


Numbers = NDArray[np.float64]
STEPS_DB = (8.0, 4.0, 2.0)


class Staircases(Means):
    """Paired differences of two thresholds by reversals; ``threshold_error_db`` is the error of one."""

    def gaps(
        self, rng: np.random.Generator, batch: StudyBatch, truth: float
    ) -> tuple[Numbers, dict[str, float]]:
        first = rng.normal(-BELOW_START_DB, 4.0, batch.shape)
        gaps = rng.normal(truth, batch.assumed.person_sd, first.shape)
        both = np.stack([first, first + gaps], -1)
        estimates = simulated_thresholds(both, batch.trials, slope=batch.assumed.trial_sd, rng=rng)
        return estimates[..., 1] - estimates[..., 0], {"threshold_error_db": float((estimates - both).std())}


def simulated_thresholds(
    place: Numbers,
    trials: int,
    *,
    slope: float,
    rng: np.random.Generator,
) -> Numbers:
    """Return the mean of reversals of 1 up 3 down staircases with two alternatives, for each simulated observer, dB.

    ``place`` is the middle of each observer's logistic function, dB above the start. Without the first two reversals;
    the last intensity where there are too few.
    """
    x = np.zeros(place.shape)
    run, heading, turned, counted = (np.zeros(place.shape, int) for _ in range(4))
    total = np.zeros(place.shape)
    for _ in range(trials):
        right = rng.random(place.shape) < 0.5 + 0.5 * special.expit(slope * (x - place))
        run = np.where(right, run + 1, 0)
        move = np.where(~right, 1, np.where(run >= 3, -1, 0))
        reversal = (move != 0) & (heading != 0) & (move != heading)
        turned += reversal
        taken = reversal & (turned > 2)
        total += np.where(taken, x, 0.0)
        counted += taken
        x = x + move * np.asarray(STEPS_DB)[np.minimum(turned, len(STEPS_DB) - 1)]
        run = np.where(move != 0, 0, run)
        heading = np.where(move != 0, move, heading)
    return np.where(counted > 1, total / np.maximum(counted, 1), x)
