"""A ladder of mixes as one figure: what each step looks like and where it lies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation.generation.spectrogram_figures import Scale, draw_spectrograms
from tactogram.evaluation.measures.sets import check_alike
from tactogram.evaluation.mixing.placement import MixingLadder
from tactogram.signal import Signal
from tactogram.statistics.figures import AXIS_COLOURS, INK

MARKERS = "s^vDP*"
"""One per axis, beside its colour: lines can be told apart without seeing colours."""


def mixing_figure(
    steps: Sequence[Signal],
    ladder: MixingLadder,
    *,
    start: str,
    end: str,
    start_weights: Sequence[float] | None = None,
    scale: Scale = "dB",
    seconds: float = 4.0,
    title: str = "",
) -> Figure:
    """Draw a ladder of mixes as in Figures 15 to 18 of Saga et al., and below it where each step lies.

    Above each column stands the weight of ``end``, below it that of ``start``. The lower left plot shows each
    step's position between the ends with the spread of its signals, a line per axis and a thick one for all;
    the bands around 0 and 1 are the ends' own spread. The lower right plot shows how far off the line it is.

    Parameters
    ----------
    steps : sequence of Signal
        One for each step of ``ladder``.
    start, end : str
        Names of the materials.
    start_weights : sequence of float, optional
        Of ``start``; by default 1 less those of ``end``.
    scale : {"dB", "0-1"}
        As in `spectrograms_figure`; 0-1 is over all steps of an axis.
    seconds : float
        How much of each step is shown.

    Raises
    ------
    ParameterError
        If steps and ladder do not fit together.
    """
    if len(steps) != len(ladder.weights):
        raise ParameterError(f"steps must be {len(ladder.weights)} as in the ladder, got {len(steps)}")
    first = check_alike(steps)
    below = 1 - ladder.weights if start_weights is None else np.asarray(start_weights, float)
    rows = len(first.axes)
    figure = Figure(figsize=(10, 3.4 + 1.15 * rows), layout="constrained")
    parts = figure.subfigures(2, 1, squeeze=False, height_ratios=(0.8 + 1.15 * rows, 2.6))
    upper, lower = parts[:, 0]
    grid = upper.subplots(rows, len(steps), squeeze=False)
    draw_spectrograms(upper, grid, [steps], scale, seconds)
    for column, weight in enumerate(ladder.weights):
        grid[0, column].set_title(f"{weight:.2g}", fontsize=8)
        grid[-1, column].set_xlabel(f"{below[column]:.2g}", fontsize=8)
        grid[-1, column].set_xticks([])
    upper.suptitle(f"weight of {end}", fontsize=8)
    upper.supxlabel(
        f"weight of {start}   (each picture {min(first.seconds, seconds):.2g} s long)", fontsize=8
    )
    left, right = lower.subplots(1, 2, width_ratios=(2.2, 1))
    _draw_positions(left, ladder, start, end)
    _draw_off_line(right, ladder, end)
    if title:
        figure.suptitle(title, fontsize=10)
    return figure


def _draw_positions(place: Axes, ladder: MixingLadder, start: str, end: str) -> None:
    for at, spread in zip((0, 1), ladder.end_spread[:, -1], strict=True):
        place.axhspan(at - spread, at + spread, color="#d8dee4", lw=0)
        place.axhline(at, color="#57606a", lw=0.8, ls=":")
    place.axhline(0.5, color="#57606a", lw=0.8, ls="--")
    for column, name in enumerate(ladder.columns[:-1]):
        colour = AXIS_COLOURS[column % len(AXIS_COLOURS)]
        if len(ladder.columns) > 2 and not np.isnan(ladder.position[:, column]).any():
            marker = MARKERS[column % len(MARKERS)]
            place.plot(
                ladder.weights,
                ladder.position[:, column],
                lw=1,
                marker=marker,
                ms=4,
                color=colour,
                label=name,
            )
    place.errorbar(
        ladder.weights,
        ladder.position[:, -1],
        ladder.spread[:, -1],
        color=INK,
        lw=2.2,
        marker="o",
        ms=4,
        elinewidth=1.2,
        capsize=3,
        label="all axes",
        zorder=3,
    )
    half = ladder.half_weight[-1]
    if np.isfinite(half):
        place.plot([half], [0.5], marker="D", ms=7, mfc="white", mec=INK, mew=1.5, zorder=4)
        place.annotate(
            f"half way at {half:.2f}", (half, 0.5), (8, -12), textcoords="offset points", fontsize=8
        )
    place.set(xlabel=f"weight of {end}", ylabel="position", xlim=_margin(ladder.weights))
    place.set_title(f"0: {start}   1: {end}   bars: ± 1 standard deviation over signals", fontsize=8)
    if len(ladder.columns) > 2:
        place.legend(frameon=False, fontsize=8, loc="best")
    _small(place)


def _draw_off_line(place: Axes, ladder: MixingLadder, end: str) -> None:
    for column, name in enumerate(ladder.columns):
        last = column == len(ladder.columns) - 1
        if last or (len(ladder.columns) > 2 and not np.isnan(ladder.off_line[:, column]).any()):
            place.plot(
                ladder.weights,
                ladder.off_line[:, column],
                color=INK if last else AXIS_COLOURS[column % len(AXIS_COLOURS)],
                lw=2.2 if last else 1,
                marker="o" if last else MARKERS[column % len(MARKERS)],
                ms=4,
                label=name,
            )
    top = max(0.5, 1.1 * float(np.nanmax(ladder.off_line)))
    place.set(
        xlabel=f"weight of {end}", ylabel="off the line", xlim=_margin(ladder.weights), ylim=(-0.02, top)
    )
    place.set_title("1: as far as the ends are apart", fontsize=8)
    _small(place)


def _small(place: Axes) -> None:
    place.tick_params(labelsize=8)
    place.xaxis.label.set_fontsize(8)
    place.yaxis.label.set_fontsize(8)


def _margin(weights: NDArray[np.float64]) -> tuple[float, float]:
    room = 0.04 * float(weights[-1] - weights[0])
    return float(weights[0]) - room, float(weights[-1]) + room
