"""Spectrograms side by side, as Saga et al. print them: recorded beside generated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure, SubFigure
from numpy.typing import NDArray
from scipy.signal import stft

from tactogram.evaluation.figures import unit_text
from tactogram.evaluation.measures.sets import check_alike
from tactogram.signal import Signal

WINDOW, HOP = 256, 128
"""Samples, Hamming, at up to `PAPER_RATE` (Saga et al. 2020, Sec. III-B); as long in time at higher rates."""
PAPER_RATE = 1000.0
LOWEST_HZ, HIGHEST_HZ = 10.0, 1000.0
"""What is drawn. Below lie gravity and the arm, which would set the scale; above, nothing is felt."""
GAP = 0.08
"""Width of the space between groups, in pictures."""
RANGE_DB = 60.0
"""What lies farther below the strongest point is drawn as black."""

Scale = Literal["0-1", "dB"]


@dataclass(frozen=True, eq=False)
class _SpectrogramPanel:
    """One axis of one signal: magnitudes, shape (frequency, time)."""

    frequency: NDArray[np.float64]
    time: NDArray[np.float64]
    magnitude: NDArray[np.float64]


def spectrograms_figure(
    groups: Mapping[str, Mapping[str, Signal]],
    *,
    scale: Scale = "0-1",
    seconds: float = 4.0,
    title: str = "",
) -> Figure:
    """Draw spectrograms in groups side by side, one row per axis, as in Figures 7 to 9 of Saga et al.

    Parameters
    ----------
    groups : mapping from str to mapping from str to Signal
        For example ``{"tile": {"recorded": …, "generated": …}}``; all of one rate, unit and set of axes.
    scale : {"0-1", "dB"}
        ``0-1`` divides the magnitudes of a row of a group by the largest of them: one scale for what is to be
        compared, made for the picture alone. ``dB`` is re 1 unit per bin and one for the whole figure: it keeps
        the level.
    seconds : float
        How much is shown from the beginning.

    Raises
    ------
    ParameterError
        If there is nothing to draw, or the signals are of several kinds.
    """
    every = [signal for members in groups.values() for signal in members.values()]
    first = check_alike(every)
    rows = len(first.axes)
    # A narrow empty column between groups.
    widths = [w for members in groups.values() for w in (*[1.0] * len(members), GAP)][:-1]
    figure = Figure(figsize=(max(5.0, 1.3 + 1.4 * sum(widths)), 1.0 + 1.35 * rows), layout="constrained")
    cells = figure.subplots(rows, len(widths), squeeze=False, width_ratios=widths)
    for place in cells[:, [column for column, width in enumerate(widths) if width == GAP]].flat:
        place.remove()
    grid = cells[:, [column for column, width in enumerate(widths) if width != GAP]]
    draw_spectrograms(figure, grid, [list(members.values()) for members in groups.values()], scale, seconds)
    names = [(name, label) for name, members in groups.items() for label in members]
    for place, (name, label) in zip(grid[0], names, strict=True):
        place.set_title(f"{fill(name, 17)}\n{label}", fontsize=8)
    for place in grid[-1]:
        place.set_xlabel("time, s", fontsize=8)
    if title:
        figure.suptitle(title, fontsize=10)
    return figure


def draw_spectrograms(
    figure: Figure | SubFigure,
    grid: NDArray[Any],
    groups: Sequence[Sequence[Signal]],
    scale: Scale,
    seconds: float,
) -> None:
    """Draw the signals of ``groups`` into the columns of ``grid``, and a colour bar beside it.

    Parameters
    ----------
    figure : Figure or SubFigure
        What holds ``grid``.
    grid : object array of Axes, shape (axis, signal)
    groups : sequence of sequences of Signal
        Signals of a group share one scale per axis when ``scale`` is ``0-1``.
    scale, seconds
        As in `spectrograms_figure`.
    """
    first = groups[0][0]
    drawn = [[_pictures(signal, seconds) for signal in members] for members in groups]
    loudest = max(_largest(pictures) for members in drawn for pictures in members)
    top = 20 * np.log10(loudest)
    column = 0
    for members in drawn:
        for row in range(len(first.axes)):
            largest = _largest([pictures[row] for pictures in members])
            for place, pictures in enumerate(members):
                picture, cell = pictures[row], grid[row, column + place]
                if scale == "dB":
                    values, limits = (
                        20 * np.log10(np.maximum(picture.magnitude, 1e-12)),
                        (top - RANGE_DB, top),
                    )
                else:
                    values, limits = picture.magnitude / largest, (0.0, 1.0)
                half = (picture.frequency[1] - picture.frequency[0]) / 2
                mesh = cell.imshow(
                    values,
                    origin="lower",
                    aspect="auto",
                    # The first frame begins at 0, the last ends as far behind its middle.
                    extent=(
                        0,
                        picture.time[-1] + picture.time[0],
                        picture.frequency[0] - half,
                        picture.frequency[-1] + half,
                    ),
                    vmin=limits[0],
                    vmax=limits[1],
                    cmap="magma",
                    interpolation="nearest",
                )
                # Numbers at the edges of the figure only; ticks are what drawing takes longest for.
                cell.tick_params(labelsize=7, length=2)
                if row < len(first.axes) - 1:
                    cell.set_xticks([])
                if column + place > 0:
                    cell.set_yticks([])
        column += len(members)
    for row, name in enumerate(first.axes):
        grid[row, 0].set_ylabel(f"{name}\nfrequency, Hz", fontsize=8)
    bar = figure.colorbar(mesh, ax=grid, fraction=0.03, pad=0.01, aspect=30)
    share = "magnitude" if len(drawn) == 1 else "magnitude per group"
    bar.set_label(
        f"dB re 1 {unit_text(first.unit)}" if scale == "dB" else f"{share}\n1: largest on the axis",
        fontsize=8,
    )
    bar.ax.tick_params(labelsize=7)


def _pictures(signal: Signal, seconds: float) -> list[_SpectrogramPanel]:
    """Return the spectrogram of each axis of the beginning of ``signal``."""
    shown = signal.cut(0, max(2, round(min(signal.seconds, seconds) * signal.rate)))
    window = min(round(WINDOW * max(1.0, signal.rate / PAPER_RATE)), len(shown))
    samples = shown.samples.astype(np.float64)
    f, t, z = stft(
        samples - samples.mean(axis=1, keepdims=True),
        signal.rate,
        "hamming",
        nperseg=window,
        noverlap=window - window * HOP // WINDOW,
        boundary=None,
        padded=False,
    )
    kept = (f >= LOWEST_HZ) & (f <= HIGHEST_HZ)
    return [_SpectrogramPanel(f[kept], t, np.abs(one[kept])) for one in z]


def _largest(pictures: Sequence[_SpectrogramPanel]) -> float:
    """Return the largest magnitude; 1 where all is silent, so that one can divide by it."""
    return max(float(picture.magnitude.max()) for picture in pictures) or 1.0
