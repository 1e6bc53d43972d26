"""Analysis of a vibration as events, and their synthesis as a vibration.

Only what an actuator plays and a finger feels counts: 0 to 1000 Hz without the constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import sample_count
from tactogram.rendering.files.events import (
    JUMP_S,
    PULSE_S,
    STEP_S,
    UNKNOWN_HZ,
    Events,
    Line,
    Part,
    Transient,
    joined,
    transient_shape,
    voices,
)
from tactogram.signal import Signal

WINDOW_S = 0.020
"""Hann window over which the power is averaged, s: a file's curve cannot follow anything faster."""
FINE_STEP_S, FINE_WINDOW_S = 0.001, 0.004
"""Grid and window for detecting transients, s."""
FREQUENCY_WINDOW_S = 0.040
"""Hann window over which the frequency is averaged, s."""
HIGHEST_HZ = 1000.0
"""Vibration above it is not felt, Hz."""
ONSET_SHARE = 0.2
"""A transient exceeds the vibration by this share of the strongest moment, and is twice as strong as 20 ms before."""
ONSET_DISTANCE_S = 0.050
"""Transients closer than this are one, s."""
QUIET = 0.01
"""Share of the strongest moment below which a vibration counts as silence: -40 dB, and what a filter rings."""
READ_RATE, RATE_PER_HZ = 8000.0, 2.5
"""Default rate of a carrier, Hz, and a higher one's samples per period of the highest frequency."""
LEAK = 0.1
"""Share of a signal's strength up to which its cut at either end leaks into what is felt. A choice."""


def envelope_of(signal: Signal, *, low: float = 0.0, high: float = HIGHEST_HZ, step: float = STEP_S) -> Part:
    """Return the envelope of a signal of one axis over time, every ``step`` s.

    The power of the analytic signal (Gabor 1946) above ``low`` and up to ``high`` Hz, averaged over `WINDOW_S`; the
    frequency is the phase of the analytic signal's autocorrelation at a lag of one sample, averaged over
    `FREQUENCY_WINDOW_S`: the mean frequency, exact for a sine. Raises `ParameterError` if there are several axes, or
    the signal is over displacement.
    """
    z, rate = _analytic(signal, low, high)
    times = np.concatenate([[0.0], np.arange(step, signal.seconds - step / 2, step), [signal.seconds]])
    amplitude = _strength(z, WINDOW_S, rate, times)
    return Part(times, amplitude, _frequency(z, rate, times, amplitude))


def events_of(signal: Signal, bands: Sequence[tuple[float, float]] = ()) -> Events:
    """Return the events of a signal of one axis over time: its envelope, silent where the signal is, and transients.

    Onsets faster than the envelope become transients; the envelope steps there, so that both together keep the energy.
    With ``bands`` (Hz) there is an envelope for each, and no transient. Errors as of `envelope_of`.
    """
    if bands:
        envelopes = [_quieted(envelope_of(signal, low=low, high=high), signal) for low, high in bands]
        return Events(signal.seconds, tuple(part for part in envelopes if part.peak > 0))
    envelope, transients = _with_onsets(_quieted(envelope_of(signal), signal), signal)
    return Events(signal.seconds, (envelope,) if envelope.peak > 0 else (), transients)


def carrier(events: Events, rate: float | None = None) -> Signal:
    """Return a vibration of these events: sines that follow frequencies and amplitudes, of unit 1.

    Vibrations of one constant frequency are joined, and those whose frequency varies as `voices`. ``rate`` is
    `READ_RATE` by default, or `RATE_PER_HZ` times the highest frequency. Raises `ParameterError` if ``rate`` leaves no
    sample, or is too low for the carrier.
    """
    highest = max(events.frequencies, default=0.0)
    rate = rate or max(READ_RATE, math.ceil(RATE_PER_HZ * highest))
    count = sample_count(events.seconds, rate)
    if count < 1:
        raise ParameterError(f"{events.seconds:g} s at {rate:g} Hz leave no sample; use a higher rate")
    steady: dict[float, list[Part]] = {}
    for part in events.parts:
        if np.ptp(part.frequency) < 1e-3:
            steady.setdefault(round(float(part.frequency[0]), 3), []).append(part)
    varying = voices(part for part in events.parts if np.ptp(part.frequency) >= 1e-3)
    if highest >= rate / 2:
        raise ParameterError(f"a carrier of {highest:g} Hz needs more than {2 * highest:g} Hz, got {rate:g}")
    t = np.arange(count) / rate
    x, phase = np.zeros((2, count))
    for parts in (*steady.values(), *varying):
        voice = joined(parts)
        hz = voice.hz(t)
        phase = 2 * np.pi * (np.cumsum(hz) - hz) / rate
        x += voice.at(t) * np.sin(phase)
    whole = events.joined
    strongest = {tap.time: tap for tap in sorted(events.transients, key=lambda tap: tap.amplitude)}
    for tap in strongest.values():
        first = min(count - 1, max(0, math.ceil(tap.time * rate - 1e-6)))
        inside = slice(first, min(count, first + math.ceil(PULSE_S * rate)))
        away = t[inside] - t[first]
        # In phase with the vibration, so that the two add up to the transient's strength.
        excess = np.maximum(tap.amplitude * transient_shape(away) - whole.at(t[inside]), 0)
        x[inside] += excess * np.sin(phase[first] + 2 * np.pi * tap.frequency * away)
    return Signal(x.astype(np.float32), rate, "1")


def power_felt(signal: Signal) -> float:
    """Return the share of a signal's power, without its constant, that is below `HIGHEST_HZ`; 1 of silence."""
    x = signal.samples.astype(np.float64)
    power = (np.abs(fft.rfft(x - x.mean(axis=1, keepdims=True))) ** 2).sum(axis=0)
    last = int(HIGHEST_HZ * x.shape[1] / signal.rate) + 1
    return float(power[:last].sum() / power.sum()) if power.any() else 1.0


def _quieted(envelope: Part, signal: Signal) -> Part:
    """Return an envelope that is 0 where it or the signal itself is quiet: a filter rings before and after a click."""
    x = np.abs(signal.samples[0] - np.median(signal.samples[0]))
    near = scipy.ndimage.maximum_filter1d(x, max(1, round(WINDOW_S * signal.rate)))
    loud = _at(near, envelope.times * signal.rate) > QUIET * x.max(initial=0.0)
    heard = (envelope.amplitude > QUIET * envelope.peak) & loud
    heard &= ~_leaking(envelope.times, envelope.amplitude, signal)
    return replace(envelope, amplitude=np.where(heard, envelope.amplitude, 0.0))


def _leaking(times: Line, strength: Line, signal: Signal) -> NDArray[np.bool_]:
    """Return whether a strength is only what a filter leaves, or a cut at either end, of a signal that is not felt."""
    x = signal.samples[0] - np.median(signal.samples[0])
    whole = math.sqrt(2) * _strength(x, WINDOW_S, signal.rate, times)
    ends = np.minimum(times, signal.seconds - times) < WINDOW_S
    return np.asarray(strength < np.where(ends, LEAK, QUIET) * whole)


def _analytic(signal: Signal, low: float, high: float) -> tuple[NDArray[np.complex128], float]:
    """Return the analytic signal within a band at a rate of 4 `HIGHEST_HZ` or the signal's own, and that rate.

    The signal is continued by its mirror image, so that the ends make no step. Errors as of `envelope_of`.
    """
    if len(signal.axes) != 1:
        raise ParameterError(f"an envelope needs one axis, got {', '.join(signal.axes)}; choose one")
    if signal.domain != "time":
        raise ParameterError("an envelope is over time: convert the displacement at a speed first (play_at)")
    x = signal.samples[0].astype(np.float64)
    length = 2 * len(x)
    spectrum = fft.rfft(np.concatenate([x, x[::-1]]))
    frequency = fft.rfftfreq(length, 1 / signal.rate)
    spectrum[(frequency <= low) | (frequency > high)] = 0
    points = length
    if signal.rate > 4 * HIGHEST_HZ:
        held = np.count_nonzero(frequency <= high)
        points = fft.next_fast_len(max(2, held, round(length * 4 * HIGHEST_HZ / signal.rate)))
    z: NDArray[np.complex128] = fft.ifft(2 * spectrum, points) * (points / length)
    return z[: max(1, round(points / 2))], signal.rate * points / length


def _averaged(x: NDArray[Any], width: float) -> NDArray[Any]:
    """Return ``x`` averaged under a Hann window of ``width`` samples, which is shortened at the ends."""
    n = max(1, 2 * round(width / 2) - 1)
    window = np.hanning(n + 2)[1:-1]
    total, weight = (scipy.signal.oaconvolve(values, window, mode="same") for values in (x, np.ones(len(x))))
    return np.asarray(total / weight)


def _strength(z: NDArray[Any], window: float, rate: float, times: Line) -> Line:
    """Return the root of the power of an analytic (or real) signal, averaged over ``window`` (s), at times."""
    return np.sqrt(np.maximum(_at(_averaged(np.abs(z) ** 2, window * rate), times * rate), 0))


def _at(x: Line, places: Line) -> Line:
    return np.asarray(np.interp(places, np.arange(len(x)), x))


def _frequency(z: NDArray[np.complex128], rate: float, times: Line, amplitude: Line) -> Line:
    loud = amplitude > QUIET * amplitude.max(initial=0.0)
    if len(z) < 2 or not loud.any():
        return np.full(len(times), UNKNOWN_HZ)
    lag = np.conj(z[:-1]) * z[1:]
    turning = np.maximum(np.angle(_averaged(lag, FREQUENCY_WINDOW_S * rate)), 0) * rate / (2 * np.pi)
    frequency = _at(turning, times * rate)
    return np.asarray(np.interp(times, times[loud], frequency[loud]))


def _with_onsets(envelope: Part, signal: Signal) -> tuple[Part, tuple[Transient, ...]]:
    """Return the envelope that steps at onsets that are faster than it can follow, and these as transients."""
    z, rate = _analytic(signal, 0.0, HIGHEST_HZ)
    times = np.arange(0, signal.seconds, FINE_STEP_S)
    fine = _strength(z, FINE_WINDOW_S, rate, times)
    least = ONSET_SHARE * fine.max(initial=0.0)
    if len(times) < 3 or least == 0:
        return envelope, ()
    # An onset may be the very first moment, which is a peak only after silence.
    peaks, _ = scipy.signal.find_peaks(
        np.concatenate([[0.0], fine - envelope.at(times), [0.0]]),
        height=least,
        distance=max(1, round(ONSET_DISTANCE_S / FINE_STEP_S)),
    )
    peaks = peaks - 1
    ago = round(WINDOW_S / FINE_STEP_S)
    before = np.where(peaks >= ago, fine[np.maximum(peaks - ago, 0)], 0.0)
    transients = []
    sudden = (fine[peaks] - before >= fine[peaks] / 2) & ~_leaking(times, fine, signal)[peaks]
    for peak in peaks[sudden].tolist():
        # The window has half of a step at its time.
        i = peak
        while i > max(0, peak - ago) and fine[i - 1] >= fine[peak] / 2:
            i -= 1
        with_step, strength = _onset(envelope, float(times[i]))
        if strength - float(with_step.at(times[i])) >= least / 2:
            envelope = with_step
            transients.append(Transient(float(times[i]), strength, float(envelope.hz(times[i]))))
    return envelope, tuple(transients)


def _onset(envelope: Part, here: float) -> tuple[Part, float]:
    """Return the envelope that steps at an onset, and the strength of the transient that keeps the energy with it."""
    reach = WINDOW_S + STEP_S
    t = np.arange(max(0.0, here - reach), here + reach, FINE_STEP_S)
    old = envelope.at(t)
    low, high = float(min(old[0], old[-1])), float(old[-1])
    base, shape = np.where(t < here - 1e-9, low, high), transient_shape(t - here + 1e-9)
    energy, cross, rest = float(shape @ shape), float(base @ shape), float(base @ base - old @ old)
    under = cross**2 - energy * rest
    excess = (math.sqrt(under) - cross) / energy if under > 0 else 0.0
    kept = (envelope.times < t[0]) | (envelope.times > t[-1])
    bends = np.array([t[0], here - JUMP_S, here, min(t[-1], envelope.end)])
    levels = np.array([low, low, high, high])
    new = (bends >= 0) & np.append(np.diff(bends) > 0, True)
    times, first = np.unique(np.append(envelope.times[kept], bends[new]), return_index=True)
    amplitude = np.append(envelope.amplitude[kept], levels[new])[first]
    return Part(times, amplitude, envelope.hz(times)), high + max(0.0, excess)
