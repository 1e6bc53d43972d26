"""Mixing ladder of a run: its signals, their positions, and the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation.generation.spectrogram_figures import SHOWN_S, draw_spectrograms
from tactogram.evaluation.measures.measure import check_alike
from tactogram.evaluation.mixing.placement import MixingLadder
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportSound, ReportTable, ReportText
from tactogram.signal import Signal
from tactogram.signal.figure import AXIS_COLOURS
from tactogram.statistics.figures import INK

Mode = Literal["sum", "add"]

MODES = {
    "sum": "the two weights sum to 1",
    "add": "the start keeps the weight 1 and the end is added",
}
"""The two ways of mixing labels (Saga et al. 2020, Sec. V)."""
MARKERS = "s^vDP*"
"""One per axis, so that lines are distinguishable without colour."""


@dataclass(frozen=True, eq=False)
class MixSeries:
    """Ladder of mixes that a run generates from one material to another."""

    start: str
    end: str
    mode: Mode
    shown: tuple[Signal, ...]
    """One signal per step, all of one seed, to view and listen to."""
    ladder: MixingLadder
    """Positions between the run's signals of the pure materials."""
    without_level: MixingLadder | None
    """Positions by spectrum and modulation alone; None where the ends differ only in level."""
    against_recordings: MixingLadder | None
    """Positions between test recordings; None where a material has fewer than two, or they are indistinguishable."""
    simulated: bool
    """Whether the run was trained on simulated data."""

    @property
    def start_weights(self) -> NDArray[np.float64]:
        """Weight of ``start`` at each step."""
        weights = self.ladder.weights
        return np.ones_like(weights) if self.mode == "add" else np.round(1 - weights, 12)

    def figure(self, *, title: str = "") -> Figure:
        """Draw spectrograms of the steps, and their positions below."""
        return mixing_figure(
            self.shown,
            self.ladder,
            start=self.start,
            end=self.end,
            start_weights=self.start_weights.tolist(),
            title=title,
        )

    def caption(self, step: int) -> str:
        """Return the composition of a step, e.g. ``0.4 tile, 0.6 cork``."""
        return f"{self.ladder.weights[step]:.2g} {self.end}, {self.start_weights[step]:.2g} {self.start}"

    def in_words(self) -> str:
        """Return the direction, the midpoint and the distance from the line, in three sentences."""
        ladder = self.ladder
        if ladder.monotone[-1]:
            moves = f"moves one way, from {ladder.position[0, -1]:z.2f} to {ladder.position[-1, -1]:z.2f}"
        elif ladder.tau_low[-1] > 0:
            moves = f"rises, but falls back by {ladder.largest_drop[-1]:.2f} on its way"
        else:
            moves = "does not rise beyond what chance explains"
        half = ladder.half_weight[-1]
        if np.isfinite(half):
            low, high = ladder.half_low[-1], ladder.half_high[-1]
            upper = f"{high:.2f}" if np.isfinite(high) else "never"
            crossing = f"It is half way at {half:.2f} of {self.end} (95 %: {low:.2f} to {upper})."
        else:
            crossing = f"It never gets half way to {self.end}."
        return (
            f"The ladder {moves}. {crossing} At most it lies {np.max(ladder.off_line[:, -1]):.2f} of the ends' "
            f"distance ({ladder.distance_db[-1]:.1f} dB) off the line between them; steps closer than "
            f"{ladder.resolution[-1]:.2g} cannot be told apart."
        )

    def section(self, title: str = "") -> ReportSection:
        """Return the section of a report: summary, figure, table and sounds."""
        ladder = self.ladder
        rows = [
            (
                f"{ladder.weights[k]:.2g}",
                f"{self.start_weights[k]:.2g}",
                float(ladder.position[k, -1]),
                float(ladder.spread[k, -1]),
                float(ladder.off_line[k, -1]),
            )
            for k in range(len(self.shown))
        ]
        table = ReportTable(
            (f"weight of {self.end}", f"weight of {self.start}", "position", "± sd", "off the line"),
            rows,
            "Position between the model's signals of the pure materials (0: the one, 1: the other), from levels in "
            "third-octave bands and depths of modulation in dB; ± over signals. Off the line: as a share of the "
            "ends' distance, less what chance explains.",
        )
        return ReportSection(
            title or f"From {self.start} to {self.end}",
            [
                ReportText(self.in_words()),
                ReportFigure(
                    self.figure(), f"{len(rows)} steps from {self.start} to {self.end}, and their positions."
                ),
                table,
                *(ReportSound(signal, self.caption(k)) for k, signal in enumerate(self.shown)),
            ],
        )


def mixing_figure(
    steps: Sequence[Signal],
    ladder: MixingLadder,
    *,
    start: str,
    end: str,
    start_weights: Sequence[float] | None = None,
    title: str = "",
) -> Figure:
    """Draw a ladder of mixes as in Figures 15 to 18 of Saga et al., and the positions of its steps below.

    The weight of ``end`` is above each column, that of ``start`` below it. The lower left plot shows each step's
    position between the ends with the spread of its signals, a line per axis and a thick one for all; the bands
    around 0 and 1 are the spread of the ends. The lower right plot shows the distance from the line between the ends.

    There is one of ``steps`` for each of the ladder's; ``start`` and ``end`` are the materials' names. The weights of
    ``start`` are 1 - those of ``end`` by default. Raises `ParameterError` if the number of steps differs.
    """
    if len(steps) != len(ladder.weights):
        raise ParameterError.must("steps", f"be {len(ladder.weights)} as in the ladder", len(steps))
    first = check_alike(steps)
    below = 1 - ladder.weights if start_weights is None else np.asarray(start_weights, float)
    rows = len(first.axes)
    figure = Figure(figsize=(10, 3.4 + 1.15 * rows), layout="constrained")
    parts = figure.subfigures(2, 1, squeeze=False, height_ratios=(0.8 + 1.15 * rows, 2.6))
    upper, lower = parts[:, 0]
    grid = upper.subplots(rows, len(steps), squeeze=False)
    draw_spectrograms(upper, grid, [steps], "dB")
    for column, weight in enumerate(ladder.weights):
        grid[0, column].set_title(f"{weight:.2g}", fontsize=8)
        grid[-1, column].set_xlabel(f"{below[column]:.2g}", fontsize=8)
        grid[-1, column].set_xticks([])
    upper.suptitle(f"weight of {end}", fontsize=8)
    upper.supxlabel(
        f"weight of {start}   (each picture {min(first.seconds, SHOWN_S):.2g} s long)", fontsize=8
    )
    left, right = lower.subplots(1, 2, width_ratios=(2.2, 1))
    _draw_positions(left, ladder, start, end)
    _draw_off_line(right, ladder, end)
    if title:
        figure.suptitle(title, fontsize=10)
    return figure


def _draw_positions(panel: Axes, ladder: MixingLadder, start: str, end: str) -> None:
    for level, spread in zip((0, 1), ladder.end_spread[:, -1], strict=True):
        panel.axhspan(level - spread, level + spread, color="#d8dee4", lw=0)
        panel.axhline(level, color="#57606a", lw=0.8, ls=":")
    panel.axhline(0.5, color="#57606a", lw=0.8, ls="--")
    _draw_axes(panel, ladder, ladder.position)
    panel.errorbar(
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
        panel.plot([half], [0.5], marker="D", ms=7, mfc="white", mec=INK, mew=1.5, zorder=4)
        panel.annotate(
            f"half way at {half:.2f}", (half, 0.5), (8, -12), textcoords="offset points", fontsize=8
        )
    panel.set_ylabel("position")
    panel.set_title(f"0: {start}   1: {end}   bars: ± 1 standard deviation over signals", fontsize=8)
    if len(ladder.columns) > 2:
        panel.legend(frameon=False, fontsize=8, loc="best")
    _label_weights(panel, ladder, end)


def _draw_off_line(panel: Axes, ladder: MixingLadder, end: str) -> None:
    _draw_axes(panel, ladder, ladder.off_line)
    panel.plot(ladder.weights, ladder.off_line[:, -1], color=INK, lw=2.2, marker="o", ms=4)
    panel.set(ylabel="off the line", ylim=(-0.02, max(0.5, 1.1 * float(np.nanmax(ladder.off_line)))))
    panel.set_title("1: as far as the ends are apart", fontsize=8)
    _label_weights(panel, ladder, end)


def _draw_axes(panel: Axes, ladder: MixingLadder, values: NDArray[np.float64]) -> None:
    """Draw a line per axis in which the ends differ, if there are several axes."""
    axes = ladder.columns[:-1] if len(ladder.columns) > 2 else ()
    for column, name in enumerate(axes):
        if not np.isnan(values[:, column]).any():
            panel.plot(
                ladder.weights,
                values[:, column],
                lw=1,
                marker=MARKERS[column % len(MARKERS)],
                ms=4,
                color=AXIS_COLOURS[column % len(AXIS_COLOURS)],
                label=name,
            )


def _label_weights(panel: Axes, ladder: MixingLadder, end: str) -> None:
    first, last = ladder.weights[0], ladder.weights[-1]
    room = 0.04 * (last - first)
    panel.set(xlabel=f"weight of {end}", xlim=(first - room, last + room))
    panel.tick_params(labelsize=8)
    panel.xaxis.label.set_fontsize(8)
    panel.yaxis.label.set_fontsize(8)
