"""Figure of realism: the marks of both conditions, and their difference."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tactogram.statistics.figures import BLUE, GRAY, INK, ORANGE
from tactogram.study.analysis.figures import SLANTED, title_of
from tactogram.study.analysis.findings import AnalysisSection, Finding


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
        at = np.arange(len(rows)) + 0.38 * (k - 0.5)
        left.bar(at, means, 0.36, yerr=errors, color=colour, capsize=2, label=condition)
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
