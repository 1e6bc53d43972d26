"""Figures of a simulated transducer: transmission of an envelope, and tracking of its resonance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.experiments.simulated_transducer import SimulatedTouch, TrackingResult
from tactogram_playback.transducer.circuit import Transducer

INK, GRAY, BLUE, ORANGE = "#1b1f24", "#9aa0a6", "#2166ac", "#d6604d"
METHOD_COLOURS = {
    "climb_admittance": "#b35806",
    "dither_admittance": "#d6604d",
    "dither_conductance": "#4d9221",
    "motional_phase": "#2166ac",
}
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EnvelopeTransmission:
    """Transmission of an envelope through a simulated transducer.

    Parameters
    ----------
    rate : float, Hz
    wanted, driven, arrived : float64 arrays, shape (time,)
        The wanted modulation (-1..1); amplitudes of the drive and of the motion, as shares of the largest drive.
    frequency, gain : float64 arrays, shape (line,)
        Hz, and the strength of a component relative to the slowest.
    expected : float64 array, shape (line,)
        The same by formula.
    flat_to_hz : float
        As reported; 0 if nothing is flat.
    """

    title: str
    rate: float
    wanted: Array
    driven: Array
    arrived: Array
    frequency: Array
    gain: Array
    expected: Array
    flat_to_hz: float


def envelope_figure(
    rows: Sequence[tuple[EnvelopeTransmission, EnvelopeTransmission]],
    *,
    start_s: float,
    seconds: float,
    title: str = "",
) -> Figure:
    """Return a row per transducer: without and with pre-emphasis, over time (a part of it) and over frequency."""
    figure = Figure(figsize=(13, 2.6 * len(rows) + 1), layout="constrained")
    axes = figure.subplots(len(rows), 3, squeeze=False, width_ratios=(1.25, 1.25, 1), sharex="col")
    for row, pair in zip(axes, rows, strict=True):
        for place, passed in zip(row[:2], pair, strict=True):
            part = slice(int(start_s * passed.rate), int((start_s + seconds) * passed.rate))
            at = 1e3 * np.arange(part.stop - part.start) / passed.rate
            place.fill_between(
                at, -passed.driven[part], passed.driven[part], color=GRAY, alpha=0.35, lw=0, label="AM drive"
            )
            place.plot(at, passed.arrived[part], color=BLUE, lw=1.3, label="recovered envelope (simulated)")
            mean, swing = passed.arrived.mean(), passed.arrived.std() / passed.wanted.std()
            place.plot(
                at,
                mean + swing * passed.wanted[part],
                "--",
                color=ORANGE,
                lw=0.9,
                label="wanted, to its size",
            )
            place.set_title(passed.title, fontsize=9)
            place.set_ylim(-1.05, 1.05)
            place.set_ylabel("amplitude / limit")
        for passed, colour, name in zip(pair, (ORANGE, BLUE), ("without", "with pre-emphasis"), strict=True):
            formula = 20 * np.log10(passed.expected)
            row[2].semilogx(passed.frequency, formula, color=GRAY, lw=3, alpha=0.6, label="formula")
            some = np.unique(np.geomspace(1, len(passed.frequency), 24).astype(int)) - 1
            db = 20 * np.log10(passed.gain[some])
            row[2].semilogx(passed.frequency[some], db, ".", ms=5, color=colour, label=f"{name}, simulated")
        row[2].axvline(pair[1].flat_to_hz, color=BLUE, ls=":", lw=1, label="reported flat to")
        row[2].axhline(-3.01, color=GRAY, lw=0.6)
        row[2].set_ylim(-32, 4)
        row[2].set_ylabel("arrives / dB")
        row[2].grid(alpha=0.25, which="both")
    for place, name in zip(axes[-1], ("ms", "ms", "modulating frequency / Hz"), strict=True):
        place.set_xlabel(name)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    more = axes[0, 2].get_legend_handles_labels()
    unique = dict(zip([*labels, *more[1]], [*handles, *more[0]], strict=True))
    figure.legend(
        unique.values(), unique.keys(), loc="outside lower center", ncols=4, fontsize=8, frameon=False
    )
    figure.suptitle(title, fontsize=11)
    return figure


def tracking_figure(
    columns: Mapping[str, Mapping[str, TrackingResult]],
    *,
    touches: Sequence[SimulatedTouch] = (),
    title: str = "",
) -> Figure:
    """Return carrier and resonance over the steps, and the error, a column per transducer and a colour per method.

    Touches are shaded in columns whose title contains "touched".
    """
    figure = Figure(figsize=(4.6 * len(columns), 6.2), layout="constrained")
    axes = figure.subplots(2, len(columns), squeeze=False, sharex=True, height_ratios=(1.2, 1))
    for (upper, lower), (name, methods) in zip(axes.T, columns.items(), strict=True):
        for method, result in methods.items():
            colour = METHOD_COLOURS.get(method, INK)
            steps = np.arange(len(result.carrier_hz))
            faint = 0.6 if method.startswith("climb") else 1.0
            name_of = method.replace("_", " ")
            upper.plot(steps, result.carrier_hz, color=colour, lw=1, alpha=faint, label=name_of)
            lower.plot(steps, result.errors_hz, color=colour, lw=1, alpha=faint)
        resonance = next(iter(methods.values())).resonance_hz
        upper.plot(np.arange(len(resonance)), resonance, "--", color=INK, lw=1.1, label="true resonance")
        lower.axhline(0, color=INK, lw=0.8, ls="--")
        if "touched" in name:
            for touch in touches:
                for place in (upper, lower):
                    place.axvspan(touch.start, touch.stop, color=GRAY, alpha=0.2, lw=0)
        upper.set_title(name, fontsize=10)
        lower.set_xlabel("step")
        upper.grid(alpha=0.25)
        lower.grid(alpha=0.25)
    axes[0, 0].set_ylabel("carrier / Hz")
    axes[1, 0].set_ylabel("carrier less resonance / Hz")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8, frameon=False)
    figure.suptitle(title, fontsize=11)
    return figure


def admittance_figure(transducers: Mapping[str, Transducer], *, title: str = "") -> Figure:
    """Return conductance and magnitude of the admittance near the resonance, with both maxima marked."""
    figure = Figure(figsize=(4.2 * len(transducers), 3.4), layout="constrained")
    axes = figure.subplots(1, len(transducers), squeeze=False)[0]
    for place, (name, t) in zip(axes, transducers.items(), strict=True):
        span = 4 * t.envelope_cutoff_hz
        f = np.linspace(t.resonance_hz - span, t.resonance_hz + span, 4001)
        y = 1e3 * t.admittance(f)
        for values, colour, label in ((np.abs(y), ORANGE, "|Y|"), (y.real, BLUE, "Re Y")):
            place.plot(f - t.resonance_hz, values, color=colour, lw=1.3, label=label)
            top = int(values.argmax())
            place.plot(f[top] - t.resonance_hz, values[top], "o", color=colour, ms=4)
        place.axvline(0, color=INK, lw=0.8, ls="--")
        place.set_xlabel("frequency less resonance / Hz")
        place.set_title(name, fontsize=10)
    axes[0].set_ylabel("mS")
    axes[0].legend(fontsize=8, frameon=False)
    figure.suptitle(title, fontsize=11)
    return figure
