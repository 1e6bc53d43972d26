"""What is seen of a rendering: the signal, its drive within the limits, what was wanted and what comes out."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy import signal as dsp

from tactogram.rendering.display import Display
from tactogram.rendering.fit import Drive
from tactogram.rendering.report import SENTENCES
from tactogram.rendering.response import Table
from tactogram.signal.signal import Signal

COLUMNS = 1200
"""Of a waveform: more samples are drawn as the range of those that share a column."""


def drive_figure(drive: Drive, display: Display, *, title: str = "") -> Figure:
    """Return signal and drive over time, spectra or octave levels, and the report's sentences."""
    figure = Figure(figsize=(10, 6.4), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(3, 2), height_ratios=(1, 1, 0.62))
    _waveform(figure.add_subplot(grid[0, 0]), drive.source, "signal")
    below = figure.add_subplot(grid[1, 0])
    _waveform(below, drive.signal, "drive", steps=display.rate <= 1000 and len(drive.signal) < COLUMNS)
    for edge in {display.limit, display.floor}:
        below.axhline(edge, color="tab:red", linewidth=0.8, linestyle="--")
    below.set_xlabel("time, s")
    levels = figure.add_subplot(grid[:2, 1])
    if drive.report.facts.get("bands"):
        _octaves(levels, drive.report.facts["bands"], drive.source.unit)
    else:
        _spectra(levels, drive.source, drive.signal)
    words = figure.add_subplot(grid[2, :])
    words.axis("off")
    lines = [f"{name}: {sentence}" for name in SENTENCES for sentence in getattr(drive.report, name)]
    text = "\n".join(fill(line, 150, subsequent_indent="    ") for line in lines)
    words.text(0, 1, text, va="top", ha="left", fontsize=7.5, family="monospace", transform=words.transAxes)
    figure.suptitle(title or f"{display.title}\nlevel {drive.report.level['asked']}", fontsize=10)
    return figure


def response_figure(display: Display, *, coherence: Sequence[tuple[float, float]] = ()) -> Figure:
    """Return a display's response: gain in dB and phase over frequency, and the coherence where it was measured.

    Parameters
    ----------
    display : Display
        With a response.
    coherence : sequence of (frequency in Hz, share)
    """
    figure = Figure(figsize=(7, 5), layout="constrained")
    rows: Any = figure.subplots(3 if coherence else 2, 1, sharex=True)
    response = display.response
    if response is None:
        raise ValueError(f"{display.name} has no response")
    if isinstance(response, Table):
        low, high = response.range
    else:
        low, high = display.band or (10.0, display.rate / 2)
    frequency = np.geomspace(low, high, 400)
    values = response.at(frequency)
    rows[0].semilogx(frequency, 20 * np.log10(np.abs(values)))
    rows[0].set_ylabel(f"gain, dB re\n1 {response.unit} per {display.unit}")
    rows[1].semilogx(frequency, np.degrees(np.unwrap(np.angle(values))))
    rows[1].set_ylabel("phase, °")
    if coherence:
        at, share = np.array(coherence).T
        rows[2].semilogx(at, share)
        rows[2].set(ylabel="coherence", ylim=(0, 1.05))
    rows[-1].set_xlabel("frequency, Hz")
    for axes in rows:
        axes.grid(alpha=0.3, which="both")
    figure.suptitle(display.title, fontsize=10)
    return figure


def _waveform(axes: Axes, signal: Signal, name: str, *, steps: bool = False) -> None:
    for row, label in zip(signal.samples, signal.axes, strict=True):
        time, low, high = _ranges(row, signal.rate)
        if steps:
            axes.step(time, high, where="post", linewidth=0.9, label=label)
        elif np.array_equal(low, high):
            axes.plot(time, high, linewidth=0.8, label=label)
        else:
            axes.fill_between(time, low, high, linewidth=0.4, alpha=0.8, label=label)
    unit = "" if signal.unit == "1" else f", {signal.unit}"
    axes.set(ylabel=f"{name}{unit}", xlim=(0, signal.seconds))
    axes.grid(alpha=0.3)
    if len(signal.axes) > 1:
        axes.legend(fontsize=7, ncols=4, loc="upper right")


def _ranges(row: NDArray[np.float32], rate: float) -> tuple[NDArray[np.float64], Any, Any]:
    """Return time in s, and the lowest and highest sample of each column of the picture."""
    per_column = -(-len(row) // COLUMNS)
    count = len(row) // per_column
    cut = row[: count * per_column].reshape(count, per_column)
    return np.arange(count) * per_column / rate, cut.min(axis=1), cut.max(axis=1)


def _octaves(axes: Axes, bands: Sequence[dict[str, Any]], unit: str) -> None:
    centres = [row["centre_hz"] for row in bands]
    for key, style in (("wanted_db", "o-"), ("rendered_db", "s--")):
        levels = [np.nan if row[key] is None else row[key] for row in bands]
        axes.semilogx(centres, levels, style, markersize=4, label=key.removesuffix("_db"))
    for row in bands:
        if not row["reachable"]:
            centre = row["centre_hz"]
            axes.axvspan(centre / 2**0.5, centre * 2**0.5, color="0.85", zorder=0)
    axes.set_xticks(centres, [f"{centre:g}" for centre in centres])
    axes.minorticks_off()
    axes.set(xlabel="octave, Hz (grey: out of the display's band)", ylabel=f"level, dB re 1 {unit} rms")
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)


def _spectra(axes: Axes, source: Signal, drive: Signal) -> None:
    for signal, name in ((source, "signal"), (drive, "drive")):
        length = min(len(signal), int(np.ceil(signal.rate / 2)))
        x = signal.samples[0].astype(np.float64)
        frequency, density = dsp.welch(x - x.mean(), signal.rate, nperseg=length)
        if density.max() > 0:
            level = 10 * np.log10(np.maximum(density / density.max(), 1e-9))
            axes.semilogx(frequency[1:], level[1:], linewidth=0.9, label=name)
    axes.set(xlabel="frequency, Hz", ylabel="density, dB re its largest", ylim=(-90, 5))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
