"""Figure of preferences: the strength of each item."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tactogram.statistics.figures import BLUE, GRAY
from tactogram.study.analysis.figures import title_of
from tactogram.study.analysis.findings import AnalysisSection


def preference_figure(section: AnalysisSection) -> Figure:
    """Draw the strength of each item with its interval, the most preferred on top."""
    rows = next(iter(section.tables.values()))
    figure = Figure(figsize=(6.4, 1.4 + 0.36 * max(3, len(rows))), layout="constrained")
    axes = figure.add_subplot()
    at = np.arange(len(rows))
    strengths = np.array([row["strength"] for row in rows])
    ends = np.array([[row["low"], row["high"]] for row in rows], float)
    axes.errorbar(
        strengths, at, xerr=np.nan_to_num(np.abs(ends - strengths[:, None])).T, fmt="o", color=BLUE, capsize=3
    )
    axes.set_yticks(at, [str(row["item"]) for row in rows])
    axes.invert_yaxis()
    axes.axvline(0, color=GRAY, lw=0.8)
    axes.set_xlabel("log strength, mean 0 (95 % by participant)")
    axes.set_title(title_of(section), fontsize=10)
    return figure
