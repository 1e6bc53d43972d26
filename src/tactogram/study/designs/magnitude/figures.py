"""Figure of magnitude estimation: geometric means over intensity."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from tactogram.statistics.figures import BLUE, ORANGE
from tactogram.study.analysis.figures import title_of
from tactogram.study.analysis.findings import AnalysisSection


def magnitude_figure(section: AnalysisSection) -> Figure:
    """Draw geometric means over intensity, both logarithmic, with the power law of the mean exponent."""
    rows = section.tables["geometric means"]
    x = np.array([row["intensity"] for row in rows], float)
    figure = Figure(figsize=(5.6, 4.4), layout="constrained")
    axes = figure.add_subplot()
    known = bool(np.isfinite(x).all())
    at = x if known else np.arange(len(rows), dtype=float)
    means = np.array([row["geometric_mean"] for row in rows])
    ends = np.array([[row["low"] or m, row["high"] or m] for row, m in zip(rows, means, strict=True)])
    axes.errorbar(at, means, np.abs(ends - means[:, None]).T, fmt="o", color=BLUE, capsize=3)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(ScalarFormatter())
    far = ends.max() > 4 * ends.min()  # over less than that, 1, 2 and 5 may not be there to be named
    axes.yaxis.set_minor_formatter(NullFormatter() if far else ScalarFormatter())
    if far:
        axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    if known:
        axes.set_xscale("log")
        slope = section.role("confirmatory")[0].estimate
        middle = np.log(means).mean() - slope * np.log(at).mean()
        line = np.sort(at)
        axes.set_xticks(line, [f"{value:.3g}" for value in line])
        axes.set_xticks([], minor=True)
        axes.plot(
            line, np.exp(middle + slope * np.log(line)), color=ORANGE, lw=1, label=f"exponent {slope:.2f}"
        )
        axes.legend(frameon=False, fontsize=9)
    else:
        axes.set_xticks(at, [str(row["stimulus"]) for row in rows], rotation=30)
    axes.set(xlabel="intensity" if known else "stimulus", ylabel="estimate, geometric mean (95 %)")
    axes.set_title(title_of(section), fontsize=10)
    return figure
