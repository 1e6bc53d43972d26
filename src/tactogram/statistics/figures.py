"""Colours of all figures, and the bar chart that evaluation and studies share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from tactogram.signal.figure import AXIS_COLOURS

INK, BLUE, ORANGE, GRAY = "#1b1f24", "#2166ac", "#d6604d", "#8a8f98"


def error_figure(
    rows: Mapping[str, tuple[float, float]],
    *,
    marked: Sequence[tuple[str, str, str]] = (),
    lines: Mapping[str, float] | None = None,
    label: str = "mean absolute error to the plates' scores,\npoints of the scale",
    title: str = "",
) -> Figure:
    """Draw means as bars with standard errors, like Fig. 7 of the ultrasonic display's publication.

    ``marked`` are pairs joined by a bracket with a text, ``lines`` levels for comparison by name.
    """
    figure = Figure(figsize=(2.2 + 1.05 * len(rows), 4.6), layout="constrained")
    axes = figure.add_subplot()
    names = list(rows)
    means, errors = np.array([rows[name] for name in names]).T
    axes.bar(range(len(names)), means, 0.62, yerr=errors, color=[GRAY, *[BLUE] * (len(names) - 1)], capsize=4)
    top = float((means + errors).max())
    for step, (first, second, text) in enumerate(marked):
        a, b = sorted((names.index(first), names.index(second)))
        height = top * (1.06 + 0.09 * step)
        axes.plot(
            [a, a, b, b], [height - 0.015 * top, height, height, height - 0.015 * top], color=INK, lw=0.9
        )
        axes.text((a + b) / 2, height, text, ha="center", va="bottom", fontsize=8)
    for (name, value), colour in zip((lines or {}).items(), AXIS_COLOURS[1:], strict=False):
        axes.axhline(value, color=colour, ls="--", lw=1, label=f"{name} ({value:.2f})")
    axes.set_xticks(range(len(names)), names)
    axes.set_ylim(0, top * (1.12 + 0.09 * len(marked)))
    axes.set_ylabel(label)
    axes.set_title(title, fontsize=10)
    if lines:
        figure.legend(loc="outside lower center", fontsize=8, frameon=False, ncols=2)
    return figure
