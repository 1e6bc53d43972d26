"""Mixing ladder of a run: its signals, their positions, and the report."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.evaluation.mixing.figures import mixing_figure
from tactogram.evaluation.mixing.placement import MixingLadder
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportSound, ReportTable, ReportText
from tactogram.signal import Signal

Mode = Literal["sum", "add"]

MODES = {
    "sum": "the two weights sum to 1",
    "add": "the start keeps the weight 1 and the end is added",
}
"""The two ways of mixing labels (Saga et al. 2020, Sec. V)."""


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
