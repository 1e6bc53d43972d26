"""Measured response of a display: a sweep is played and recorded, and the recording divided by the sweep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.rendering import Display, display_family, fade_window
from tactogram.signal import Signal, resample

LEAD_S = 0.05
"""Part of the response before its first arrival, s, faded in: a band-limited response rings before it, too."""
WIDER = (0.5, 1.4)
"""A sweep begins an octave below the wanted band and ends half an octave above, since its own ends are inaccurate."""
RINGING_S = 0.25
"""Part of the response after its first arrival that is not noise, s."""
POINTS_PER_OCTAVE = 24
LEAST_POWER = 3e-5
"""Least power of the played spectrum, relative to its largest, that is divided by."""


def exponential_sweep(
    display: Display,
    *,
    seconds: float = 10.0,
    level: float = 0.25,
    band: tuple[float, float] | None = None,
    silence_s: float = 0.5,
) -> Signal:
    """Return a sweep with exponentially rising frequency, as a drive of ``display``.

    x(t) = A sin(2 pi f1 T / ln(f2/f1) (e^(t/T ln(f2/f1)) - 1)): each octave lasts equally long, and a display's
    distortion appears before the response, where it can be cut off (A. Farina, "Simultaneous measurement of impulse
    response and distortion with a swept-sine technique", AES Convention 108, 2000; from general knowledge of it).

    The amplitude ``level`` is a share of the display's limit. ``band`` (Hz) is the band to be measured, by default the
    display's or 10 Hz to 0.45 of its rate; the sweep exceeds it at both ends (`WIDER`) as far as the rate allows.
    Silence of ``silence_s`` before and after the sweep lets the response build up and decay. Raises `ParameterError`
    if the display is not linear, the band does not lie below half the rate, or level or times are out of range.
    """
    family = display_family(display.family)
    if not family.swept:
        raise ParameterError(
            f"{display.name} is {family.name}: a sweep is for displays whose drive has the shape of their output",
            remedy=family.measured_by,
        )
    low, high = band or display.band or (10.0, 0.45 * display.rate)
    if not 0 < low < high < display.rate / 2:
        raise ParameterError.must("band", f"be 0 < low < high < {display.rate / 2:g} Hz", (low, high))
    low, high = low * WIDER[0], max(high, min(high * WIDER[1], 0.45 * display.rate))
    if not 0 < level <= 1:
        raise ParameterError.must("level", "be a share of the limit in 0 to 1", level)
    if not (seconds * low >= 4 and silence_s >= 0):
        raise ParameterError.must("seconds", f"last 4 periods of {low:g} Hz or more", seconds)
    if display.floor >= display.rest and display.floor > -display.limit * level:
        raise ParameterError(f"{display.name} takes no negative drive: it has no response to a sweep")
    count = round(seconds * display.rate)
    t = np.arange(count) / display.rate
    sweep = scipy.signal.chirp(t, low, seconds, high, method="logarithmic", phi=-90)
    fade = min(count // 8, round(2 * display.rate / low))
    signal = np.pad(level * display.limit * sweep * fade_window(count, fade), round(silence_s * display.rate))
    samples = np.repeat(signal[None, :], len(display.channels), axis=0).astype(np.float32)
    return Signal(samples, display.rate, display.unit, display.channels)


@dataclass(frozen=True, eq=False)
class SweepResult:
    """Response of a display identified from a sweep, in ``unit``: the recording's per the drive's.

    Frequency (Hz), response (complex, without the delay) and coherence, the share of the recorded power that the
    linear response explains, have the shape (bin,). ``delay_s`` of the recording is meaningless between devices
    without a common clock.
    """

    frequency: NDArray[np.float64]
    response: NDArray[np.complex128]
    coherence: NDArray[np.float64]
    delay_s: float
    unit: str


def identify(
    played: Signal,
    recorded: Signal,
    *,
    band: tuple[float, float],
    repeats: tuple[Signal, ...] = (),
) -> SweepResult:
    """Return the response between a played sweep and its recording, each of one axis at any rate.

    The recorded spectrum is divided by the played one where that has power; in time, everything before the direct
    response (distortion) and later than `RINGING_S` after it (noise) is cut off; the rest is read in ``band`` (Hz,
    that of the sweep) at even steps per octave. The delay is determined. ``repeats`` are further recordings of the
    same sweep, averaged after alignment. Raises `ParameterError` if a signal has several axes, the recording is
    silent, or the band exceeds half a rate.
    """
    if len(played.axes) != 1 or any(len(r.axes) != 1 for r in (recorded, *repeats)):
        raise ParameterError("identify takes one played channel and one recorded axis; select them")
    if not 0 < band[0] < band[1] <= 0.5 * min(played.rate, recorded.rate):
        raise ParameterError.must(
            "band", f"be 0 < low < high, at most {0.5 * min(played.rate, recorded.rate):g} Hz", band
        )
    rate = max(played.rate, recorded.rate)
    x = _at(played, rate)
    measured = [_impulse_response(x, _at(r, rate), rate, band) for r in (recorded, *repeats)]
    count = max(2, 1 + round(np.log2(band[1] / band[0]) * POINTS_PER_OCTAVE))
    frequency = np.geomspace(*band, count)
    response = np.mean([_read(h, rate, frequency, lead) for h, lead, _, _ in measured], axis=0)
    curves = [np.interp(np.log(frequency), np.log(grid), share) for _, _, (grid, share), _ in measured]
    coherence = np.mean(curves, axis=0)
    delay = float(np.median([d for _, _, _, d in measured]))
    return SweepResult(frequency, response, coherence, delay, f"{recorded.unit}/{played.unit}")


def _impulse_response(
    x: NDArray[np.float64], y: NDArray[np.float64], rate: float, band: tuple[float, float]
) -> tuple[NDArray[np.float64], int, tuple[NDArray[np.float64], NDArray[np.float64]], float]:
    """Return the impulse response of a recording, its lead-in, coherence and delay."""
    if not y.any():
        raise ParameterError("nothing was recorded: every sample is 0")
    size = fft.next_fast_len(len(x) + len(y), real=True)
    played, recorded = fft.rfft(x, size), fft.rfft(y - y.mean(), size)
    frequency = fft.rfftfreq(size, 1 / rate)
    power = np.abs(played) ** 2
    impulse = fft.irfft(recorded * np.conj(played) / (power + LEAST_POWER * power.max()), size)
    arrival = _first_arrival(recorded * np.conj(played), frequency, band, size)
    lead = round(LEAD_S * rate)
    ringing = round(RINGING_S * rate)
    around = np.take(impulse, np.arange(arrival - lead, arrival + ringing), mode="wrap")
    ending, hann = ringing - ringing // 2, scipy.signal.windows.hann
    window = np.concatenate([hann(2 * lead)[:lead], np.ones(ringing // 2), hann(2 * ending)[ending:]])
    h = around * window
    delay = (arrival if arrival < size / 2 else arrival - size) / rate
    return h, lead, _coherence(x, y, h, arrival - lead, rate, size), delay


def _first_arrival(
    cross: NDArray[np.complex128], frequency: NDArray[np.float64], band: tuple[float, float], size: int
) -> int:
    """Return the first sample of the response: the peak of the whitened cross-correlation's envelope."""
    inside = (frequency >= band[0]) & (frequency <= band[1])
    flat = np.where(inside, cross / np.maximum(np.abs(cross), 1e-300), 0)
    full = np.zeros(size, np.complex128)
    full[: len(flat)] = flat
    return int(np.argmax(np.abs(fft.ifft(full))))


def _coherence(
    x: NDArray[np.float64], y: NDArray[np.float64], h: NDArray[np.float64], start: int, rate: float, size: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return frequency and the share of the recorded power explained by the response, smoothed over 1/12 octave."""
    model = np.roll(fft.irfft(fft.rfft(x, size) * fft.rfft(h, size), size), start)
    left = np.abs(fft.rfft(np.pad(y - y.mean(), (0, size - len(y))) - model)) ** 2
    whole = np.abs(fft.rfft(y - y.mean(), size)) ** 2
    frequency = fft.rfftfreq(size, 1 / rate)
    grid = np.geomspace(max(frequency[1], 1.0), frequency[-1], 400)
    edges = np.searchsorted(frequency, np.stack([grid * 2 ** (-1 / 24), grid * 2 ** (1 / 24)]))
    sums = [np.concatenate([[0.0], np.cumsum(p)]) for p in (left, whole)]
    upper = np.maximum(edges[1], edges[0] + 1).clip(max=len(frequency))
    lost = sums[0][upper] - sums[0][np.minimum(edges[0], upper - 1)]
    total = sums[1][upper] - sums[1][np.minimum(edges[0], upper - 1)]
    return grid, np.clip(1 - lost / np.maximum(total, 1e-300), 0, 1)


def _read(
    h: NDArray[np.float64], rate: float, frequency: NDArray[np.float64], lead: int
) -> NDArray[np.complex128]:
    """Return the response at ``frequency``, with the direct arrival at time 0."""
    t = (np.arange(len(h)) - lead) / rate
    return np.asarray(np.exp(-2j * np.pi * frequency[:, None] * t) @ h)


def _at(signal: Signal, rate: float) -> NDArray[np.float64]:
    return np.asarray(resample(signal, rate).samples[0], np.float64)
