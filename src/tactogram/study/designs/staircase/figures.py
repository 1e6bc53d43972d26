"""Figure of staircases: tracks, and thresholds of participants."""

from __future__ import annotations

from matplotlib.figure import Figure

from tactogram.signal.figure import AXIS_COLOURS
from tactogram.statistics.figures import GRAY, INK
from tactogram.study.analysis.figures import title_of
from tactogram.study.analysis.findings import AnalysisSection
from tactogram.study.answers import Answers
from tactogram.study.designs.staircase.reversals import in_order


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
