"""Magnitude estimation: geometric means, and Stevens' exponent by participant.

S. S. Stevens, "On the psychophysical law", Psychological Review 64 (1957): estimate = k intensity**exponent. Everyone
chooses numbers of another size, so that each participant's estimates are first divided by their geometric mean.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter
from scipy import stats

from tactogram.errors import DataError, ParameterError
from tactogram.statistics import BLUE, ORANGE, paired_equivalence, summary
from tactogram_study.analysis.figures import title_of
from tactogram_study.analysis.findings import AnalysisSection, Finding, Role, numeric_answers, section_of
from tactogram_study.analysis.paired import mean_finding, paired_findings
from tactogram_study.answers import Answer, Answers


def analyse_magnitude(answers: Answers, *, margin: float | None = None) -> AnalysisSection:
    """Return geometric means of estimates (``value``) by stimulus, and the exponent where intensities are known.

    Confirmatory is the mean over participants of the slopes of log estimate over log intensity, with Student's t
    interval and p against 0 (no growth). The margin is that of the exponent's difference from 1 (estimates in
    proportion), and from 0.

    The intensity is the extra column ``intensity``, else ``intensity_db`` in decibels, else ``level`` as gain=FACTOR,
    peak=SHARE or sensation=DB, else ``stimulus`` or ``condition`` if it is a number. Raises `DataError` if no estimate
    is above 0.
    """
    kept, notes = numeric_answers(answers, "magnitude")
    above = kept.where(lambda row: row.value > 0)
    if not len(above):
        raise DataError("magnitude: must have an estimate above 0, got none")
    if lost := len(kept) - len(above):
        notes += (f"{lost} estimates of 0 or below are left out: they have no logarithm",)
    logs, people = np.log(above.numbers()), np.array(above.column("participant"))
    means = {person: float(logs[people == person].mean()) for person in above.unique("participant")}
    level = np.array([means[person] for person in people])
    scale = float(np.mean(list(means.values())))
    rows = _stimuli(above, logs - level + scale)
    findings, slopes = _exponents(above, logs, margin)
    if not findings:
        notes += ("intensities are not known: no exponent; give a column intensity",)
    return section_of(
        above,
        "Magnitude estimation",
        findings,
        {"geometric means": rows, **({"exponent per participant": slopes} if slopes else {})},
        notes,
    )


def intensity_of(row: Answer) -> float:
    """Return the intensity of an answer's stimulus, > 0; NaN if it is unknown."""
    if db := row.more.get("intensity_db", ""):
        return float(10 ** (_number(db) / 20))
    kind, _, amount = row.level.partition("=")
    if kind == "sensation" and math.isfinite(_number(amount)):
        return float(10 ** (_number(amount) / 20))
    level = amount if kind in ("gain", "peak") else ""
    for text in (row.more.get("intensity", ""), level, row.stimulus, row.condition):
        value = _number(text)
        if 0 < value < math.inf:
            return value
    return math.nan


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _stimuli(above: Answers, logs: Any) -> list[dict[str, Any]]:
    """Return the geometric mean of each stimulus, with its interval over participants' means."""
    scaled = Answers(tuple(replace(row, value=float(log)) for row, log in zip(above, logs, strict=True)))
    intensities: dict[tuple[str, str], float] = {}
    for row in above:
        intensities.setdefault((row.stimulus, row.condition), intensity_of(row))
    rows = []
    for (stimulus, condition), means in scaled.participant_means("stimulus", "condition").items():
        estimate = summary(means)
        rows.append(
            {
                "stimulus": stimulus,
                "condition": condition,
                "intensity": intensities[stimulus, condition],
                "geometric_mean": math.exp(estimate.mean),
                "low": math.exp(estimate.low) if estimate.n > 1 else None,
                "high": math.exp(estimate.high) if estimate.n > 1 else None,
                "participants": estimate.n,
            }
        )
    return rows


def _exponents(above: Answers, logs: Any, margin: float | None) -> tuple[list[Finding], list[dict[str, Any]]]:
    if margin is not None and not margin > 0:
        raise ParameterError.must("margin", "be > 0", margin)
    x = np.log(np.array([intensity_of(row) for row in above]))
    people = np.array(above.column("participant"))
    rows: list[dict[str, Any]] = []
    for person in dict.fromkeys(people.tolist()):
        rated = (people == person) & np.isfinite(x)
        if len(np.unique(x[rated])) > 1:
            fit = stats.linregress(x[rated], logs[rated])
            rows.append(
                {"participant": person, "exponent": float(fit.slope), "r_squared": float(fit.rvalue) ** 2}
            )
    if not rows:
        return [], []
    slopes = np.array([row["exponent"] for row in rows])
    exponent: tuple[Role, str] = ("confirmatory", "Stevens' exponent")
    if len(slopes) < 2:
        return [mean_finding(slopes, "all", "log-log slope", *exponent, n=len(above))], rows
    estimate = summary(slopes)
    findings = [
        mean_finding(
            slopes,
            "all",
            "log-log slope by participant, Student's t",
            *exponent,
            n=len(above),
            p=float(stats.ttest_1samp(slopes, 0.0).pvalue) if estimate.sd > 0 else float(estimate.mean == 0),
            statistic=estimate.mean / estimate.se if estimate.se > 0 else None,
            equivalence_p=None if margin is None else paired_equivalence(slopes, margin=margin),
            margin=margin,
            note="p against 0: whether estimates grow with intensity",
        )
    ]
    findings += paired_findings(slopes - 1, "all", "exponent minus 1", margin=margin, n=len(above))
    return findings, rows


def magnitude_figure(section: AnalysisSection) -> Figure:
    """Draw geometric means over intensity, both logarithmic, with the power law of the mean exponent."""
    rows = section.tables["geometric means"]
    x = np.array([row["intensity"] for row in rows], float)
    figure = Figure(figsize=(5.6, 4.4), layout="constrained")
    axes = figure.add_subplot()
    known = bool(np.isfinite(x).all())
    positions = x if known else np.arange(len(rows), dtype=float)
    means = np.array([row["geometric_mean"] for row in rows])
    ends = np.array([[row["low"] or m, row["high"] or m] for row, m in zip(rows, means, strict=True)])
    axes.errorbar(positions, means, np.abs(ends - means[:, None]).T, fmt="o", color=BLUE, capsize=3)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(ScalarFormatter())
    far = ends.max() > 4 * ends.min()  # over less than that, 1, 2 and 5 may not be there to be named
    axes.yaxis.set_minor_formatter(NullFormatter() if far else ScalarFormatter())
    if far:
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    if known:
        axes.set_xscale("log")
        slope = section.role("confirmatory")[0].estimate
        middle = np.log(means).mean() - slope * np.log(positions).mean()
        line = np.sort(positions)
        axes.set_xticks(line, [f"{value:.3g}" for value in line])
        axes.set_xticks([], minor=True)
        axes.plot(
            line, np.exp(middle + slope * np.log(line)), color=ORANGE, lw=1, label=f"exponent {slope:.2f}"
        )
        axes.legend(frameon=False, fontsize=9)
    else:
        axes.set_xticks(positions, [str(row["stimulus"]) for row in rows], rotation=30)
    axes.set(xlabel="intensity" if known else "stimulus", ylabel="estimate, geometric mean (95 %)")
    axes.set_title(title_of(section), fontsize=10)
    return figure
