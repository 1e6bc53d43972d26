"""Figures that several designs share, and fonts for names; titles tell simulated participants from people."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, fontManager, get_font
from matplotlib.text import Text

from tactogram.statistics import BLUE, GRAY, INK, ORANGE
from tactogram_study.analysis.findings import AnalysisSection

SLANTED: dict[str, Any] = {"rotation": 30, "ha": "right", "rotation_mode": "anchor"}


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
    axes.set_title(f"{title_of(section)}\nall: {whole.verdict}", fontsize=10)
    return figure


def means_figure(section: AnalysisSection) -> Figure:
    """Draw the mean of each stimulus and condition over participants, with its interval."""
    rows = next(iter(section.tables.values()))
    names = [" ".join(filter(None, (str(row["stimulus"]), str(row["condition"])))) for row in rows]
    means = np.array([row["mean"] for row in rows])
    ends = np.array([[row["low"], row["high"]] for row in rows], float)
    figure = Figure(figsize=(2.6 + 0.75 * len(rows), 4.2), layout="constrained")
    axes = figure.add_subplot()
    away = np.nan_to_num(np.abs(ends - means[:, None])).T
    axes.errorbar(range(len(rows)), means, away, fmt="o", color=BLUE, capsize=3)
    axes.set_xticks(range(len(rows)), names, **SLANTED)
    axes.set_ylabel("mean (95 % by participant)")
    axes.set_title(title_of(section), fontsize=10)
    return figure


def title_of(section: AnalysisSection) -> str:
    """Return the title of a section's figure, with the number of participants."""
    who = "simulated participants" if section.simulated else "participants"
    return f"{section.title} ({section.participants} {who})"


DEFAULT_FONT = "DejaVu Sans"
"""Part of matplotlib."""
EAST_ASIAN = (
    *("Noto Sans CJK JP", "Noto Sans JP", "IPAexGothic", "IPAGothic", "TakaoGothic", "VL Gothic"),
    *("Hiragino Sans", "Yu Gothic", "Meiryo", "MS Gothic"),
    *("Noto Sans CJK SC", "Noto Sans SC", "WenQuanYi Zen Hei", "PingFang SC", "Microsoft YaHei", "SimHei"),
)
"""Fonts of Linux, macOS and Windows, where installed."""


def font_with(texts: Iterable[str]) -> str | None:
    """Return an installed font with all letters of the texts, matplotlib's default first; None if there is none."""
    letters = {ord(letter) for text in texts for letter in text}
    for font in (DEFAULT_FONT, *EAST_ASIAN):
        if font in fontManager.get_font_names() and letters <= set(
            get_font(findfont(FontProperties(family=font))).get_charmap()
        ):
            return font
    return None


def letter(figure: Figure, font: str) -> None:
    """Set the fonts of a figure's texts: matplotlib's default, and another for the letters that it lacks."""
    for text in figure.findobj(Text):
        if isinstance(text, Text):
            text.set_fontfamily([DEFAULT_FONT, font] if font != DEFAULT_FONT else [DEFAULT_FONT])
