"""Figures of a study, like those of the publications, with intervals. Each returns a matplotlib Figure.

Fig. 12 and 13 of Saga et al. (two areas), Fig. 7 of the ultrasonic display's publication and Fig. 5 and 6 of the
cross-modal one (words). What simulated participants answered says so in its title.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, ScalarFormatter

from tactogram.statistics.figures import AXIS_COLOURS, BLUE, GRAY, INK, ORANGE, error_figure
from tactogram.study.analysis.findings import SHOWN, AnalysisSection, Finding
from tactogram.study.answers import Answers
from tactogram.study.designs.staircase.reversals import in_order

Rows = Sequence[Mapping[str, Any]]
SLANTED: dict[str, Any] = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"}
MOST_BRACKETS = 6
"""Above it only those with the first condition are drawn."""


def figures_of(section: AnalysisSection, answers: Answers) -> dict[str, Figure]:
    """Return the figures of a section by file name, without suffix.

    Parameters
    ----------
    section : Section
    answers : Answers
        What it was made from, for the tracks of staircases.
    """
    tables = list(section.tables.values())
    match section.design, section.question:
        case (("two_area" | "abx"), "which"):
            return {f"{section.design}_correct": correct_figure(section)}
        case "two_area", _:
            return {"two_area_realism": realism_figure(section)}
        case "rating", _:
            return {"rating_conditions": conditions_figure(section), "rating_words": words_figure(section)}
        case "evoked", _:
            return {"evoked": evoked_figure(section)}
        case "staircase", _:
            return {"staircase": staircase_figure(section, answers)}
        case "magnitude", _:
            return {"magnitude": magnitude_figure(section)}
    return {"pairwise": preference_figure(tables[0], title=_title(section))}


def correct_figure(section: AnalysisSection) -> Figure:
    """Draw the share correct of each texture with Wilson's interval, and over all by participant, like Fig. 12."""
    rows = section.tables["share correct per texture"]
    names = [str(row["texture"]) for row in rows]
    figure = Figure(figsize=(2.6 + 0.75 * len(rows), 4.2), layout="constrained")
    axes = figure.add_subplot()
    shares = 100 * np.array([row["share"] for row in rows])
    ends = 100 * np.array([[row["wilson_low"], row["wilson_high"]] for row in rows])
    away = np.abs(ends - shares[:, None]).T
    axes.bar(range(len(rows)), shares, 0.62, color=BLUE, yerr=away, capsize=3, ecolor=INK)
    whole = section.role("confirmatory")[0]
    end = len(rows) + 0.4
    error = None
    if whole.low is not None and whole.high is not None:
        error = [[100 * (whole.estimate - whole.low)], [100 * (whole.high - whole.estimate)]]
    axes.errorbar([end], [100 * whole.estimate], error, fmt="D", color=ORANGE, ms=7, capsize=4)
    axes.axhline(50, color=INK, ls="--", lw=1)
    if whole.margin is not None:
        low, high = 50 - 100 * whole.margin, 50 + 100 * whole.margin
        axes.axhspan(
            low, high, color=GRAY, alpha=0.25, lw=0, zorder=0, label=f"margin ±{100 * whole.margin:g} points"
        )
        figure.legend(loc="outside lower right", fontsize=8, frameon=False)
    axes.set_xticks([*range(len(rows)), end], [*names, "all, by\nparticipant"])
    if len(rows) > 7 or max(map(len, names)) > 8:
        axes.set_xticks(axes.get_xticks(), [*names, "all, by\nparticipant"], **SLANTED)
    axes.set(ylim=(0, 100), ylabel="correct, % (95 % interval)")
    axes.set_title(f"{_title(section)}\nall: {whole.verdict}", fontsize=10)
    return figure


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
    figure.suptitle(f"{_title(section)}; all: {section.role('confirmatory')[0].verdict}", fontsize=10)
    return figure


def conditions_figure(section: AnalysisSection) -> Figure:
    """Draw the mean of each condition as Fig. 7 and Fig. 5 do, bracketed where participants show a difference.

    Bars have the standard error of all scores, as printed; brackets are of Wilcoxon's signed ranks by participant, with
    Holm's correction.
    """
    measure, rows = next(iter(section.tables.items()))
    shown = {str(row["condition"]): (row["mean"], row["se_as_printed"] or 0.0) for row in rows}
    marked = []
    for finding in section.role("confirmatory"):
        first, divider, second = finding.of.partition(" minus ")
        if divider and finding.p is not None and finding.verdict == SHOWN:
            marked.append((first, second, "**" if finding.p < 0.01 else "*"))
    marked.sort(key=lambda pair: abs(list(shown).index(pair[0]) - list(shown).index(pair[1])))
    if len(marked) > MOST_BRACKETS:
        marked = [pair for pair in marked if pair[0] == next(iter(shown))]
    n = rows[0]["n"]
    title = f"{_title(section)}\nn = {n:,} scores, mean ± SE; *: p < .05, **: p < .01 by participant"
    figure = error_figure(shown, marked=marked, label=measure, title=title)
    figure.set_size_inches(max(6.4, 2.2 + 1.05 * len(rows)), 4.8)
    return figure


def words_figure(section: AnalysisSection) -> Figure:
    """Draw each word under each condition with bootstrap intervals by participant, like Fig. 6."""
    name, rows = list(section.tables.items())[1]
    conditions = list(dict.fromkeys(str(row["condition"]) for row in rows))
    words = list(dict.fromkeys(str(row["word"]) for row in rows))
    figure = Figure(figsize=(2.4 + 0.85 * len(words), 4.4), layout="constrained")
    axes = figure.add_subplot()
    width = 0.8 / len(conditions)
    colours = (GRAY, *AXIS_COLOURS)
    for k, condition in enumerate(conditions):
        held = {row["word"]: row for row in rows if row["condition"] == condition}
        table = np.array(
            [[held[w][key] if w in held else np.nan for key in ("mean", "low", "high")] for w in words], float
        )
        at = np.arange(len(words)) + width * (k - (len(conditions) - 1) / 2)
        away = np.nan_to_num(np.abs(table[:, 1:] - table[:, :1]).T)
        axes.bar(
            at, table[:, 0], 0.92 * width, yerr=away, color=colours[k % len(colours)], label=condition,
            error_kw={"lw": 0.8}, capsize=1.5,
        )  # fmt: skip
    raters = [
        np.nanmean(
            [row["one_rater"] if row["one_rater"] is not None else np.nan for row in rows if row["word"] == w]
        )
        if any(row["word"] == w and row["one_rater"] is not None for row in rows)
        else np.nan
        for w in words
    ]
    if "error" in name:
        axes.plot(
            range(len(words)), raters, "_", color=INK, ms=28, mew=1.5, label="one rater and the others' mean"
        )
    axes.set_xticks(range(len(words)), words, rotation=25)
    axes.set_ylabel(f"{name.removesuffix(', per word')}\n(95 % by participant)")
    axes.set_ylim(bottom=0)
    axes.set_title(_title(section), fontsize=10)
    figure.legend(loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    return figure


def evoked_figure(section: AnalysisSection) -> Figure:
    """Draw the share of participants in whom each image evoked each word, dots where most or few is shown."""
    rows = section.tables["per image and word"]
    images = list(dict.fromkeys(str(row["image"]) for row in rows))
    words = list(dict.fromkeys(str(row["word"]) for row in rows))
    table = np.full((len(words), len(images)), np.nan)
    sure = np.zeros(table.shape, bool)
    for row in rows:
        place = words.index(row["word"]), images.index(row["image"])
        table[place], sure[place] = row["share"], row["verdict"] == "shown"
    figure = Figure(
        figsize=(min(15.0, 3.2 + 0.13 * max(len(images), 24)), 1.7 + 0.3 * len(words)), layout="constrained"
    )
    axes = figure.add_subplot()
    picture = axes.imshow(table, cmap="RdBu_r", vmin=0, vmax=1, aspect="auto")
    down, across = np.nonzero(sure)
    axes.plot(across, down, ".", color=INK, ms=3)
    figure.colorbar(picture, ax=axes, pad=0.01, label="share evoked")
    axes.set_yticks(range(len(words)), words)
    every = max(1, len(images) // 40)
    axes.set_xticks(range(0, len(images), every), images[::every], rotation=90, fontsize=6)
    axes.set_title(f"{_title(section)}\ndots: more or fewer than half is shown (Holm)", fontsize=10)
    return figure


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
    figure.suptitle(_title(section), fontsize=10)
    return figure


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
    axes.set_title(_title(section), fontsize=10)
    return figure


def preference_figure(rows: Rows, *, title: str = "") -> Figure:
    """Draw the strength of each item with its interval, the most preferred on top."""
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
    axes.set_title(title, fontsize=10)
    return figure


def _forest(axes: Axes, findings: Sequence[Finding]) -> None:
    """Draw estimates with intervals below each other, and the margin."""
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


def _title(section: AnalysisSection) -> str:
    who = "simulated participants" if section.simulated else "participants"
    return f"{section.title} ({section.participants} {who})"
