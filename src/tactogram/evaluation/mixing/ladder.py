"""A ladder of mixes of two materials: what a generator made, what the measure says of it, and its report."""

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
    """A ladder from one material to another, as a run makes it.

    Parameters
    ----------
    start, end : str
        The materials.
    mode : {"sum", "add"}
        One of `MODES`.
    shown : tuple of Signal
        One per step, all from the same seed: to look at and to listen to.
    ladder : MixingLadder
        Measured between what the run makes of the pure materials.
    without_level : MixingLadder, optional
        The same without the level; None where the ends differ in level alone.
    against_recordings : MixingLadder, optional
        The same steps between the recordings of the materials that the run was not trained on; None where
        there are fewer than two of either, or they cannot be told apart.
    simulated : bool
        Whether the run was trained on simulated data.
    """

    start: str
    end: str
    mode: Mode
    shown: tuple[Signal, ...]
    ladder: MixingLadder
    without_level: MixingLadder | None
    against_recordings: MixingLadder | None
    simulated: bool

    @property
    def start_weights(self) -> NDArray[np.float64]:
        """Weight of ``start`` at each step."""
        return (
            np.ones_like(self.ladder.weights) if self.mode == "add" else np.round(1 - self.ladder.weights, 12)
        )

    def figure(self, *, title: str = "") -> Figure:
        """Return spectrograms of the steps, and below them where each lies."""
        return mixing_figure(
            self.shown,
            self.ladder,
            start=self.start,
            end=self.end,
            start_weights=self.start_weights.tolist(),
            title=title,
        )

    def caption(self, step: int) -> str:
        """Return what is in a step, e.g. ``0.4 tile, 0.6 cork``."""
        return f"{self.ladder.weights[step]:.2g} {self.end}, {self.start_weights[step]:.2g} {self.start}"

    def in_words(self) -> str:
        """Return what the measure says of the ladder, in three sentences."""
        return _in_words(self.ladder, self.end)

    def section(self, title: str = "") -> ReportSection:
        """Return all of it for a report: the measure in words, the figure, the table and the sounds."""
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
            "Position between what the model makes of the pure materials (0: the one, 1: the other), from levels in "
            "third-octave bands and depths of modulation in dB; ± over signals. Off the line: as a share of the "
            "ends' distance, less what chance explains.",
        )
        return ReportSection(
            title or f"From {self.start} to {self.end}",
            [
                ReportText(self.in_words()),
                ReportFigure(
                    self.figure(), f"{len(rows)} steps from {self.start} to {self.end}, and where they lie."
                ),
                table,
                *(ReportSound(signal, self.caption(k)) for k, signal in enumerate(self.shown)),
            ],
        )


def _in_words(ladder: MixingLadder, end: str) -> str:
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
        crossing = f"It is half way at {half:.2f} of {end} (95 %: {low:.2f} to {upper})."
    else:
        crossing = f"It never gets half way to {end}."
    return (
        f"The ladder {moves}. {crossing} At most it lies {np.max(ladder.off_line[:, -1]):.2f} of the ends' distance "
        f"({ladder.distance_db[-1]:.1f} dB) off the line between them; steps closer than "
        f"{ladder.resolution[-1]:.2g} cannot be told apart."
    )
