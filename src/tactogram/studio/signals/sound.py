"""Browser sound of a signal: one channel at a sound card's rate, its gain, and what was limited."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
import soundfile
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.resampling import resample

RATE = 48_000
NORMAL_PEAK = 0.5
"""Largest sample, in full scales, of what is played at a level of its own: 6 dB below full scale."""
KNEE = 0.8
"""Above which the limiter bends; no sample exceeds 1."""
FADE_S = 0.005
LONGEST_S = 60.0
"""What is longer is cut: a page plays what it shows, not an archive."""
WALKED_MM_S = 100.0
"""How fast a signal over displacement is walked through."""
MOST_GAIN = 1e9


@dataclass(frozen=True)
class AudioClip:
    """Sound as played by the browser.

    Parameters
    ----------
    wav : bytes
        One channel, float32, `RATE`.
    gain : float
        Full scales per unit of the signal.
    limited : float
        Share of samples that the limiter bent.
    own_level : bool
        Whether ``gain`` was chosen so that this signal peaks at `NORMAL_PEAK`: then loudness says nothing.
    """

    wav: bytes
    gain: float
    limited: float
    own_level: bool


def sound_of(signal: Signal, *, gain: float | None = None) -> AudioClip:
    """Return what the browser plays of a signal.

    Axes become one by DFT321, which keeps the power at every frequency; the mean is taken out; the ends are faded in
    5 ms. A signal over displacement is walked through at `WALKED_MM_S`.

    Parameters
    ----------
    signal : Signal
    gain : float, optional
        Full scales per unit, the same for signals that are to be compared in strength; by default such that the
        largest sample is `NORMAL_PEAK`.

    Raises
    ------
    ParameterError
        If ``gain`` is not > 0 and finite.
    """
    if gain is not None and not 0 < gain <= MOST_GAIN:
        raise ParameterError(f"gain must be > 0 and at most {MOST_GAIN:g}, got {gain}")
    x = _one_channel(signal)
    own = gain is None
    if gain is None:
        peak = float(np.abs(x).max())
        gain = min(NORMAL_PEAK / peak, MOST_GAIN) if peak > 0 else 1.0
    played, bent = limited(gain * x)
    fade = min(len(played) // 2, round(FADE_S * RATE))
    if fade:
        ramp = np.sin(np.linspace(0, np.pi / 2, fade, endpoint=False)) ** 2
        played[:fade] *= ramp
        played[-fade:] *= ramp[::-1]
    out = io.BytesIO()
    soundfile.write(out, played.astype(np.float32), RATE, "FLOAT", format="WAV")
    return AudioClip(out.getvalue(), gain, bent, own)


def sound_bytes(signal: Signal, *, gain: float | None = None) -> bytes:
    """Return the WAV file of `sound_of`."""
    return sound_of(signal, gain=gain).wav


def common_gain(peaks: list[float]) -> float:
    """Return the gain at which the strongest of some signals peaks at `NORMAL_PEAK`, and all keep their strengths.

    Parameters
    ----------
    peaks : list of float
        As of `tactogram.studio.signals.traits.peak_of`; several axes add up to at most the root of their number.
    """
    peak = max(peaks, default=0.0)
    return min(NORMAL_PEAK / peak, MOST_GAIN) if peak > 0 else 1.0


def limited(x: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return ``x`` with what exceeds `KNEE` bent smoothly so that it stays within 1, and the share that was bent."""
    size = np.abs(x)
    over = size > KNEE
    room = 1 - KNEE
    bent = KNEE + room * np.tanh((size - KNEE) / room)
    return np.where(over, np.sign(x) * bent, x), float(over.mean())


def _one_channel(signal: Signal) -> NDArray[np.float64]:
    """Return float64, shape (time,), at `RATE`, without its mean."""
    if signal.domain == "displacement":
        signal = Signal(signal.samples, signal.rate * WALKED_MM_S, signal.unit, signal.axes)
    signal = signal.cut(0, max(1, round(LONGEST_S * signal.rate)))
    while len(signal.axes) > 1:
        signal = _combined(signal)
    x = signal.samples.astype(np.float64)
    centred = signal.with_samples((x - x.mean()).astype(np.float32))
    if len(centred) * RATE / centred.rate >= 1:
        centred = resample(centred, RATE)
    one: NDArray[np.float64] = centred.samples[0].astype(np.float64)
    return one


def _combined(signal: Signal) -> Signal:
    """Return a signal of which the first three axes, or two, have become one by DFT321."""
    from tactogram.signal import dft321

    x = signal.samples
    first = np.zeros((3, len(signal)), np.float32)
    first[: len(x[:3])] = x[:3]  # an axis of zeros adds neither power nor phase
    one = dft321(Signal(first, signal.rate, signal.unit)).samples
    names = tuple(f"axis {number}" for number in range(1 + len(x[3:])))
    return Signal(np.concatenate([one, x[3:]]), signal.rate, signal.unit, names)
