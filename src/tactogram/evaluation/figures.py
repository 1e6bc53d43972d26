"""Matplotlib figures of results and signals, neither shown nor saved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.signal import welch

from tactogram.signal import Signal
from tactogram.signal.figure import AXIS_COLOURS, unit_text
from tactogram.statistics.figures import INK


def confusion_figure(counts: NDArray[np.int64], names: Sequence[str], *, title: str = "") -> Figure:
    """Draw a confusion matrix like Table I of Saga et al.: rows are true classes and sum to 1.

    ``counts`` has shape (true class, answered class).
    """
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    size = max(4.5, 1.6 + 0.32 * len(names))
    figure = Figure(figsize=(size + 1.2, size), layout="constrained")
    axes = figure.add_subplot()
    picture = axes.imshow(share, cmap="Blues", vmin=0, vmax=1)
    figure.colorbar(picture, ax=axes, fraction=0.04, pad=0.02, label="share of the true class")
    axes.set_xticks(range(len(names)), names, rotation=90, fontsize=7)
    axes.set_yticks(range(len(names)), names, fontsize=7)
    axes.set(xlabel="answered", ylabel="touched", title=title)
    axes.tick_params(length=0)
    for row, column in np.argwhere(share >= 0.005):
        value = share[row, column]
        text = "1" if value > 0.995 else f"{value:.2f}".lstrip("0")
        axes.text(
            column, row, text, ha="center", va="center", fontsize=5.5, color="white" if value > 0.55 else INK
        )
    return figure


def spectra_figure(signals: Mapping[str, Sequence[Signal]], *, title: str = "") -> Figure:
    """Draw the mean power spectrum of each group of signals, one plot per axis, with a band from smallest to largest.

    All signals have one rate, unit and set of axes.
    """
    first = next(iter(signals.values()))[0]
    segment = min(256, *(len(signal) for members in signals.values() for signal in members))
    figure = Figure(figsize=(9, 2.6), layout="constrained")
    grid = figure.subplots(1, len(first.axes), squeeze=False, sharey=True)[0]
    for colour, (group, members) in zip(AXIS_COLOURS, signals.items(), strict=False):
        for axes, name in zip(grid, first.axes, strict=True):
            spectra = []
            for signal in members:
                f, power = welch(signal.axis(name), signal.rate, nperseg=segment)
                spectra.append(10 * np.log10(power + 1e-20))
            stack = np.stack(spectra)
            axes.plot(f, stack.mean(0), lw=1.2, color=colour, label=group)
            if len(stack) > 1:
                axes.fill_between(f, stack.min(0), stack.max(0), color=colour, alpha=0.2, lw=0)
            axes.set(xlabel="frequency, Hz", title=name)
            axes.margins(x=0)
    grid[0].set_ylabel(f"dB re 1 ({unit_text(first.unit)})²/Hz")
    grid[-1].legend(frameon=False, fontsize=8)
    if title:
        figure.suptitle(title, fontsize=10)
    return figure


def losses_figure(metrics: Sequence[Mapping[str, Any]], *, title: str = "") -> Figure:
    """Draw the curves of metrics.jsonl over steps, one per name, as `plot_losses`."""
    figure = Figure(figsize=(9, 2.8), layout="constrained")
    axes = figure.add_subplot()
    names = [n for n in dict.fromkeys(k for m in metrics for k in m) if n not in ("stage", "step")]
    plot_losses(axes, {name: [(m["step"], m[name]) for m in metrics if name in m] for name in names})
    axes.set(xlabel="step", title=title)
    axes.margins(x=0)
    axes.legend(frameon=False)
    return figure


def plot_losses(axes: Axes, losses: Mapping[str, Sequence[tuple[int, float]]]) -> None:
    """Plot values over steps, one curve per name: thin as logged, thick averaged over a 25th of them."""
    for colour, (name, points) in zip(AXIS_COLOURS, losses.items(), strict=False):
        step, value = np.array(points).T
        axes.plot(step, value, lw=0.5, alpha=0.4, color=colour)
        width = max(1, len(value) // 25)
        smooth = np.convolve(value, np.ones(width) / width, "valid")
        axes.plot(step[width - 1 :], smooth, lw=1.6, color=colour, label=name)
