"""Spectrograms side by side, recorded and generated, as in Saga et al."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure, SubFigure
from numpy.typing import NDArray
from scipy.signal import stft

from tactogram.evaluation.measures.measure import check_alike
from tactogram.signal import Signal
from tactogram.signal.figure import unit_text

WINDOW, HOP = 256, 128
"""Samples, Hamming, at up to `PAPER_RATE` (Saga et al. 2020, Sec. III-B); as long in time at higher rates."""
PAPER_RATE = 1000.0
LOWEST_HZ, HIGHEST_HZ = 10.0, 1000.0
"""Range of the frequencies. Gravity and arm motion below it would set the scale; above it, nothing is felt."""
GAP = 0.08
"""Width of the space between groups, relative to a spectrogram."""
RANGE_DB = 60.0
"""Levels farther below the strongest point are black."""
SHOWN_S = 4.0
"""Length of the drawn beginning of a signal, s."""

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
    title: str = "",
) -> Figure:
    """Draw spectrograms in groups side by side, one row per axis, as in Figures 7 to 9 of Saga et al.

    ``groups`` is for example ``{"tile": {"recorded": …, "generated": …}}``. The scale ``0-1`` divides the magnitudes of
    a row of a group by the largest of them, for display only; ``dB`` is re 1 unit per bin, one scale for the whole
    figure, which preserves the level. Raises `ParameterError` if there is no signal, or rates, units or axes differ.
    """
    every = [signal for members in groups.values() for signal in members.values()]
    first = check_alike(every)
    rows = len(first.axes)
    # A narrow empty column between groups.
    widths = [w for members in groups.values() for w in (*[1.0] * len(members), GAP)][:-1]
    figure = Figure(figsize=(max(5.0, 1.3 + 1.4 * sum(widths)), 1.0 + 1.35 * rows), layout="constrained")
    cells = figure.subplots(rows, len(widths), squeeze=False, width_ratios=widths)
    for axes in cells[:, [column for column, width in enumerate(widths) if width == GAP]].flat:
        axes.remove()
    grid = cells[:, [column for column, width in enumerate(widths) if width != GAP]]
    draw_spectrograms(figure, grid, [list(members.values()) for members in groups.values()], scale)
    names = [(name, label) for name, members in groups.items() for label in members]
    for axes, (name, label) in zip(grid[0], names, strict=True):
        axes.set_title(f"{fill(name, 17)}\n{label}", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("time, s", fontsize=8)
    if title:
        figure.suptitle(title, fontsize=10)
    return figure


def draw_spectrograms(
    figure: Figure | SubFigure, grid: NDArray[Any], groups: Sequence[Sequence[Signal]], scale: Scale
) -> None:
    """Draw the signals of ``groups`` into the columns of ``grid``, which is part of ``figure``, with a colour bar.

    ``grid`` is an object array of Axes, shape (axis, signal); ``scale`` as in `spectrograms_figure`.
    """
    first = groups[0][0]
    drawn = [[_pictures(signal) for signal in members] for members in groups]
    loudest = max(_largest(pictures) for members in drawn for pictures in members)
    top = 20 * np.log10(loudest)
    column = 0
    for members in drawn:
        for row in range(len(first.axes)):
            largest = _largest([pictures[row] for pictures in members])
            for offset, pictures in enumerate(members):
                picture, cell = pictures[row], grid[row, column + offset]
                if scale == "dB":
                    values = 20 * np.log10(np.maximum(picture.magnitude, 1e-12))
                    limits = (top - RANGE_DB, top)
                else:
                    values, limits = picture.magnitude / largest, (0.0, 1.0)
                frequency, time = picture.frequency, picture.time
                half = (frequency[1] - frequency[0]) / 2
                mesh = cell.imshow(
                    values,
                    origin="lower",
                    aspect="auto",
                    # The first frame begins at 0; the last ends half a frame after its middle.
                    extent=(0, time[-1] + time[0], frequency[0] - half, frequency[-1] + half),
                    vmin=limits[0],
                    vmax=limits[1],
                    cmap="magma",
                    interpolation="nearest",
                )
                # Numbers at the edges of the figure only: ticks take most of the drawing time.
                cell.tick_params(labelsize=7, length=2)
                if row < len(first.axes) - 1:
                    cell.set_xticks([])
                if column + offset > 0:
                    cell.set_yticks([])
        column += len(members)
    for row, name in enumerate(first.axes):
        grid[row, 0].set_ylabel(f"{name}\nfrequency, Hz", fontsize=8)
    bar = figure.colorbar(mesh, ax=grid, fraction=0.03, pad=0.01, aspect=30)
    share = "magnitude" if len(drawn) == 1 else "magnitude per group"
    label = f"dB re 1 {unit_text(first.unit)}" if scale == "dB" else f"{share}\n1: largest on the axis"
    bar.set_label(label, fontsize=8)
    bar.ax.tick_params(labelsize=7)


def _pictures(signal: Signal) -> list[_SpectrogramPanel]:
    """Return the spectrogram of each axis of the beginning of ``signal``."""
    shown = signal.cut(0, max(2, round(min(signal.seconds, SHOWN_S) * signal.rate)))
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
    return [_SpectrogramPanel(f[kept], t, np.abs(spectrum[kept])) for spectrum in z]


def _largest(pictures: Sequence[_SpectrogramPanel]) -> float:
    """Return the largest magnitude, the divisor of the scale; 1 in silence."""
    return max(float(picture.magnitude.max()) for picture in pictures) or 1.0
