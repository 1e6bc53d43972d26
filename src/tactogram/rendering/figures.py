"""Figure of a drive."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tactogram.rendering.displays.catalogue import display_family
from tactogram.rendering.displays.display import Display
from tactogram.rendering.drive.fit import Drive
from tactogram.rendering.drive.report import SENTENCES
from tactogram.signal.figure import unit_text
from tactogram.signal.signal import Signal

LINE = 40_000
"""Longest waveform drawn sample by sample …"""
COLUMNS = 2500
"""… longer ones are drawn as the range of the samples in each column."""
SLOW_HZ = 600.0
"""Drives up to this rate are drawn in steps, as the device holds them."""


def drive_figure(drive: Drive, display: Display, *, title: str = "") -> Figure:
    """Return signal and drive over time, octave levels or the strongest moment close up, and the report's sentences."""
    lines = [f"{name}: {sentence}" for name in SENTENCES for sentence in getattr(drive.report, name)]
    text = "\n".join(fill(line, 150, subsequent_indent="    ") for line in lines)
    words = 0.16 * (1 + text.count("\n"))
    figure = Figure(figsize=(10, 4.6 + words), layout="constrained")
    parts: Any = figure.subfigures(2, 1, height_ratios=(4.6, words))
    upper, lower = parts
    grid = upper.add_gridspec(2, 2, width_ratios=(3, 2))
    signal, sent = upper.add_subplot(grid[0, 0]), upper.add_subplot(grid[1, 0])
    _waveform(signal, drive.source, "signal", (0, drive.source.seconds))
    _waveform(sent, drive.signal, "drive", (0, drive.signal.seconds))
    for edge in {display.limit, display.floor}:
        sent.axhline(edge, color="tab:red", linewidth=0.8, linestyle="--")
    sent.set_xlabel("time, s (red: the limits)")
    if drive.report.facts.get("bands"):
        _octaves(upper.add_subplot(grid[:, 1]), drive.report.facts["bands"], drive.source.unit)
    else:
        seconds = display_family(display.family).close_up_s
        strongest = int(np.abs(drive.source.samples).max(axis=0).argmax()) / drive.source.rate
        start = float(np.clip(strongest - seconds / 2, 0, max(0, drive.source.seconds - seconds)))
        near = (start, min(start + seconds, drive.source.seconds))
        _waveform(upper.add_subplot(grid[0, 1]), drive.source, "", near)
        close = upper.add_subplot(grid[1, 1])
        _waveform(close, drive.signal, "", near)
        close.set_xlabel("close up, s")
    lower.text(0.01, 1, text, va="top", ha="left", fontsize=7.5, family="monospace")
    heading = title or f"{display.title}\nlevel {drive.report.level['asked']}"
    figure.suptitle(heading, fontsize=10, multialignment="center")
    return figure


def _waveform(axes: Axes, signal: Signal, name: str, span: tuple[float, float]) -> None:
    first, last = int(span[0] * signal.rate), max(1, int(np.ceil(span[1] * signal.rate)))
    part = signal.samples[:, first:last]
    for row, label in zip(part, signal.axes, strict=True):
        if len(row) <= LINE:
            steps = "steps-post" if signal.rate <= SLOW_HZ else "default"
            time = (first + np.arange(len(row))) / signal.rate
            axes.plot(time, row, linewidth=0.7, drawstyle=steps, label=label)
        else:
            time, low, high = _ranges(row, signal.rate)
            axes.fill_between(time + first / signal.rate, low, high, linewidth=0.4, alpha=0.8, label=label)
    unit = "" if signal.unit == "1" else f", {unit_text(signal.unit)}"
    axes.set(ylabel=f"{name}{unit}" if name else "", xlim=span if span[1] > span[0] else None)
    axes.grid(alpha=0.3)
    if len(signal.axes) > 1 and name:
        axes.legend(fontsize=7, ncols=4, loc="upper right")


def _ranges(row: NDArray[np.float32], rate: float) -> tuple[NDArray[np.float64], Any, Any]:
    """Return time in s, and the lowest and highest sample of each column."""
    per_column = -(-len(row) // COLUMNS)
    count = len(row) // per_column
    cut = row[: count * per_column].reshape(count, per_column)
    return np.arange(count) * per_column / rate, cut.min(axis=1), cut.max(axis=1)


def _octaves(axes: Axes, bands: Sequence[dict[str, Any]], unit: str) -> None:
    centres = [row["centre_hz"] for row in bands]
    for key, label, style in (("wanted_db", "target", "o-"), ("rendered_db", "rendered", "s--")):
        levels = [np.nan if row[key] is None else row[key] for row in bands]
        axes.semilogx(centres, levels, style, markersize=4, label=label)
    for row in bands:
        if not row["reachable"]:
            centre = row["centre_hz"]
            axes.axvspan(centre / 2**0.5, centre * 2**0.5, color="0.85", zorder=0)
    axes.set_xticks(centres, [f"{centre:g}" for centre in centres])
    axes.minorticks_off()
    of = "" if unit == "1" else f" {unit_text(unit)}"
    axes.set(xlabel="octave, Hz (grey: out of the display's band)", ylabel=f"level, dB re 1{of} rms")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
