"""Marks on a visual analogue scale under two conditions, by the same people.

As printed (Saga et al., Fig. 13): Student's t per texture, every mark taken as independent. Here: differences of each
participant's means, paired.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactogram.errors import DataError
from tactogram.statistics import BLUE, GRAY, INK, ORANGE, student_t, summary
from tactogram_study.analysis.figures import SLANTED, title_of
from tactogram_study.analysis.findings import (
    AnalysisSection,
    Finding,
    estimate_finding,
    numeric_answers,
    section_of,
)
from tactogram_study.analysis.paired import holm_paired, paired_findings
from tactogram_study.answers import Answers
from tactogram_study.statistics import mixed_difference


def analyse_realism(answers: Answers, *, margin: float | None = None) -> AnalysisSection:
    """Return the analysis of marks (``value``, mm) of textures in two conditions.

    Confirmatory is the paired t-test of the participants' means over all textures. Raises `DataError` if there are not
    two conditions, or fewer than two participants answered both.
    """
    kept, notes = numeric_answers(answers, "realism")
    names = tuple(sorted(kept.unique("condition")))
    if len(names) != 2:
        raise DataError(
            f"realism: must have two conditions to compare, got {len(names)} ({', '.join(names) or 'none'})"
        )
    measure = f"{names[0]} minus {names[1]}, mm"
    whole = _differences(kept, names)
    if len(whole) < 2:
        raise DataError(f"realism: two participants must have answered both conditions, got {len(whole)}")
    if left := kept.people - len(whole):
        notes += (f"{left} participants who met one condition only are left out",)
    values = np.array(list(whole.values()))
    findings = [
        *paired_findings(values, "all", measure, margin=margin, n=len(kept), roles=("confirmatory", "check")),
        _mixed(kept, names, measure),
    ]
    per, rows = _textures(kept, names, measure, margin)
    notes += (
        "Student's t as printed takes every mark as independent, which repeated marks of one person are not",
    )
    return section_of(
        kept,
        f"Realism: {names[0]} and {names[1]}",
        (*findings, *per),
        {"marks per texture, mm": rows},
        notes,
    )


def _differences(kept: Answers, names: tuple[str, ...]) -> dict[str, float]:
    """Return each participant's difference over the textures with both conditions, with equal weights."""
    cells = kept.values_by("participant", "stimulus", "condition")
    per: dict[str, list[float]] = {}
    for (person, item, condition), marks in cells.items():
        if condition == names[0] and (person, item, names[1]) in cells:
            per.setdefault(person, []).append(float(np.mean(marks) - np.mean(cells[person, item, names[1]])))
    return {person: float(np.mean(values)) for person, values in per.items()}


def _mixed(kept: Answers, names: tuple[str, ...], measure: str) -> Finding:
    first = np.array([row.condition == names[0] for row in kept])
    estimate = mixed_difference(kept.numbers(), first, kept.column("participant"), kept.column("stimulus"))
    test = "linear mixed model, participants and textures at random"
    return estimate_finding("all", test, measure, estimate, kept)


def _textures(
    kept: Answers, names: tuple[str, ...], measure: str, margin: float | None
) -> tuple[list[Finding], list[dict[str, Any]]]:
    groups: Mapping[str, Answers] = kept.by("stimulus")
    printed, rows, paired = [], [], {}
    for item, group in groups.items():
        marks = {name: group.where(condition=name).numbers() for name in names}
        row: dict[str, Any] = {"texture": item}
        for name, values in marks.items():
            if len(values):
                s = summary(values)
                row |= {f"{name} n": s.n, f"{name} mean": s.mean, f"{name} se": s.se}
        rows.append(row)
        if min(len(values) for values in marks.values()) >= 2:
            test = student_t(marks)
            pair = test.pairs[0]
            printed.append(
                Finding(
                    item,
                    "Student's t, uncorrected",
                    "as printed",
                    measure,
                    pair.difference,
                    p=pair.p,
                    n=len(group),
                    participants=group.people,
                    statistic=pair.statistic,
                )
            )
        differences = np.array(list(_differences(group, names).values()))
        if len(differences) >= 2:
            paired[item] = (differences, len(group))
    if len(groups) < 2 or not paired:
        return printed, rows
    return printed + holm_paired(paired, measure, margin), rows


def realism_figure(section: AnalysisSection) -> Figure:
    """Draw the marks of both conditions per texture with standard errors, like Fig. 13, and their difference."""
    [(name, rows)] = section.tables.items()
    unit = name.rpartition(", ")[2]
    conditions = [key.removesuffix(" mean") for key in rows[0] if key.endswith(" mean")]
    items = [str(row["texture"]) for row in rows]
    figure = Figure(figsize=(5.2 + 0.8 * len(rows), 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.7, 1))
    for k, (condition, colour) in enumerate(zip(conditions, (ORANGE, BLUE), strict=False)):
        means = [row.get(f"{condition} mean", np.nan) for row in rows]
        errors = [row.get(f"{condition} se", np.nan) for row in rows]
        positions = np.arange(len(rows)) + 0.38 * (k - 0.5)
        left.bar(positions, means, 0.36, yerr=errors, color=colour, capsize=2, label=condition)
    left.set_xticks(range(len(items)), items, **(SLANTED if len(items) > 5 else {}))
    left.set(ylabel=f"mark, {unit} (mean ± SE of all marks)")
    left.legend(fontsize=8, frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, 1.1))
    paired = [f for f in section.findings if f.test == "paired t by participant"]
    _forest(right, [f for f in paired if f.of != "all"] + [f for f in paired if f.of == "all"])
    right.set_xlabel(f"{paired[0].measure}\n(95 % by participant)")
    figure.suptitle(f"{title_of(section)}; all: {section.role('confirmatory')[0].verdict}", fontsize=10)
    return figure


def _forest(axes: Axes, findings: Sequence[Finding]) -> None:
    """Draw estimates with intervals as rows, and the margin."""
    for k, finding in enumerate(findings):
        last = finding.of == "all"
        if finding.low is not None and finding.high is not None:
            error = [[finding.estimate - finding.low], [finding.high - finding.estimate]]
            axes.errorbar(
                [finding.estimate],
                [k],
                xerr=error,
                fmt="D" if last else "o",
                capsize=3,
                color=ORANGE if last else BLUE,
            )
    axes.axvline(0, color=INK, lw=0.9, ls="--")
    if findings and findings[0].margin is not None:
        axes.axvspan(-findings[0].margin, findings[0].margin, color=GRAY, alpha=0.18, lw=0)
    axes.set_yticks(range(len(findings)), [finding.of for finding in findings])
    axes.invert_yaxis()
