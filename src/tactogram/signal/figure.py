"""Figure of a signal, waveform and spectrogram of each axis, and its form in a notebook, with a player.

Below `Signal`, which draws itself by this module.
"""

from __future__ import annotations

import base64
import html
import io
from typing import Protocol

import numpy as np
import soundfile
import soxr
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.signal import stft

AXIS_COLOURS = ("#2166ac", "#d6604d", "#4d9221", "#8073ac", "#b35806", "#666666")
RANGE_DB = 70.0
HEARD_S = 10.0
AUDIBLE_RATE = 8000.0
"""Hz; browsers refuse to play files below 3000."""
SPEED_MM_S = 100.0
"""Of the finger, for signals over displacement."""


class _Drawn(Protocol):
    """Members of a `tactogram.signal.Signal`, which draws itself by this module."""

    @property
    def samples(self) -> NDArray[np.float32]: ...
    @property
    def rate(self) -> float: ...
    @property
    def unit(self) -> str: ...
    @property
    def axes(self) -> tuple[str, ...]: ...
    @property
    def domain(self) -> str: ...


def signal_figure(
    signal: _Drawn, *, title: str = "", shown: float = 2.0, figure: Figure | None = None
) -> Figure:
    """Draw the beginning of a signal and its spectrogram, one row per axis.

    The spectrogram is Hamming 256, hop 128, as in Saga et al. Sec. III-B, in dB re 1 ``unit`` per bin. Only whole
    frames are drawn: zeros around the signal would look like an onset and an end.

    ``shown`` (float, s or mm): length of the waveform; the spectrogram is of the whole signal. ``figure``: to draw on;
    by default a new one, which no window shows.
    """
    rows = len(signal.axes)
    figure = Figure(layout="constrained") if figure is None else figure
    figure.set_size_inches(9, 0.6 + 1.55 * rows)
    quantity, extent, cycles = ("time", "s", "Hz") if signal.domain == "time" else ("position", "mm", "1/mm")
    grid = figure.subplots(rows, 2, squeeze=False, width_ratios=(1.4, 1), sharex="col")
    count = signal.samples.shape[1]
    beginning = signal.samples[:, : max(2, round(shown * signal.rate))]
    positions = np.arange(beginning.shape[1]) / signal.rate
    pictures = []
    window = min(256, count)
    for row, name in enumerate(signal.axes):
        grid[row, 0].plot(positions, beginning[row], lw=0.6, color=AXIS_COLOURS[row % len(AXIS_COLOURS)])
        grid[row, 0].set_ylabel(f"{name}  {unit_text(signal.unit)}")
        grid[row, 0].margins(x=0)
        frames = {"nperseg": window, "noverlap": window // 2, "boundary": None, "padded": False}
        f, t, z = stft(signal.samples[row], signal.rate, "hamming", **frames)
        pictures.append((grid[row, 1], f, t, 20 * np.log10(np.abs(z) + 1e-12)))
        grid[row, 1].set_ylabel(cycles)
    top = max(float(np.max(db)) for *_, db in pictures)
    for axes, f, t, db in pictures:
        cells = _edges(t, (window - window // 2) / signal.rate), _edges(f, signal.rate / window)
        mesh = axes.pcolormesh(*cells, db, vmin=top - RANGE_DB, vmax=top, cmap="magma", rasterized=True)
    figure.colorbar(mesh, ax=grid[:, 1], fraction=0.06, pad=0.02, label=f"dB re 1 {unit_text(signal.unit)}")
    part = "" if len(positions) == count else f" (the first {len(positions) / signal.rate:g} {extent})"
    grid[-1, 0].set_xlabel(f"{quantity}, {extent}{part}")
    grid[-1, 1].set(xlabel=f"{quantity}, {extent}", xlim=(0, count / signal.rate))
    if title:
        figure.suptitle(title, fontsize=10)
    return figure


def unit_text(unit: str) -> str:
    """Return a unit in typographic form."""
    return {"m/s^2": "m/s²", "1": "no unit"}.get(unit, unit)


def _edges(middles: NDArray[np.float64], step: float) -> NDArray[np.float64]:
    """Return the edges of cells of width ``step`` around ``middles``; shape (cell + 1,)."""
    return np.append(middles - step / 2, middles[-1] + step / 2)


def signal_html(signal: _Drawn) -> str:
    """Return a signal as HTML that needs no other file."""
    picture = io.BytesIO()
    signal_figure(signal).savefig(picture, format="png", dpi=80)
    heard = signal.samples
    rate = signal.rate
    if signal.domain == "time":
        heard = heard[:, : max(1, round(HEARD_S * rate))]
    else:
        rate *= SPEED_MM_S
    axis = strongest(heard)
    x = heard[axis] - heard[axis].mean()
    if rate < AUDIBLE_RATE:
        x, rate = soxr.resample(x, rate, AUDIBLE_RATE), AUDIBLE_RATE
    sound = base64.b64encode(wav_of(x, rate)).decode()
    drawn = base64.b64encode(picture.getvalue()).decode()
    facts = html.escape(str(signal))
    return (
        f"<p>{facts}</p>"
        f'<img alt="waveform and spectrogram of {facts}" src="data:image/png;base64,{drawn}">'
        f'<br><audio controls src="data:audio/wav;base64,{sound}"></audio>'
    )


def strongest(samples: NDArray[np.float32]) -> int:
    """Return the row, of samples (axis, time), with the most power about its mean."""
    power = np.square(samples - samples.mean(axis=1, keepdims=True), dtype=np.float64)
    return int(power.sum(axis=1).argmax())


def wav_of(x: NDArray[np.float32], rate: float) -> bytes:
    """Return one axis, shape (time,), as a WAV file, peak at 0.9."""
    file = io.BytesIO()
    sound = x / max(float(np.abs(x).max()), 1e-12) * 0.9
    soundfile.write(file, sound, round(rate), format="WAV", subtype="PCM_16")
    return file.getvalue()
