"""Figure of evoked words: shares of participants, words by images."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from tactogram.statistics.figures import INK
from tactogram.study.analysis.figures import title_of
from tactogram.study.analysis.findings import SHOWN, AnalysisSection


def evoked_figure(section: AnalysisSection) -> Figure:
    """Draw the share of participants in whom each image evoked each word, dots where most or few is shown."""
    rows = section.tables["per image and word"]
    images = list(dict.fromkeys(str(row["image"]) for row in rows))
    words = list(dict.fromkeys(str(row["word"]) for row in rows))
    table = np.full((len(words), len(images)), np.nan)
    sure = np.zeros(table.shape, bool)
    for row in rows:
        place = words.index(row["word"]), images.index(row["image"])
        table[place], sure[place] = row["share"], row["verdict"] == SHOWN
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
    axes.set_title(f"{title_of(section)}\ndots: more or fewer than half is shown (Holm)", fontsize=10)
    return figure
