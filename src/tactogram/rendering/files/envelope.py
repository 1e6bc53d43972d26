"""Envelope and frequency of a vibration over time, which most haptic files hold instead of samples.

Only what an actuator plays and a finger feels counts: 0 to 1000 Hz without the constant.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import fft

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import sample_count
from tactogram.signal import Signal

STEP_S = 0.005
"""Grid of an envelope, s."""
WINDOW_S = 0.020
"""Hann window over which its power is averaged, s: a file's curve cannot follow anything faster."""
FINE_STEP_S, FINE_WINDOW_S = 0.001, 0.004
"""The same for detecting pulses, s."""
FREQUENCY_WINDOW_S = 0.040
"""Hann window over which the frequency is averaged, s."""
HIGHEST_HZ = 1000.0
"""Vibration above it is not felt, Hz."""
PULSE_S = 0.020
"""Length of a pulse when a file is read, s: it starts at full strength and falls like half a Hann window. Devices have
their own."""
DUCKED_BEFORE_S = 0.005
"""Time before a pulse at which the envelope is reduced, s."""
PULSE_SHARE = 0.2
"""A pulse exceeds the envelope by this share of the strongest moment, and is twice as strong as 20 ms before."""
PULSE_DISTANCE_S = 0.050
"""Pulses closer than this are one, s."""
QUIET = 0.01
"""Share of the strongest moment below which the frequency is interpolated."""
LONGEST_PIECE = 200
"""Points that `thinned` processes together: its run time stays proportional to the length."""
UNKNOWN_HZ = 150.0
"""Frequency of a silent signal."""
READ_RATE = 8000.0
"""Default rate of a carrier, Hz."""
PHONE_HZ = 170.0
"""Assumed if a phone's file states no frequency: linear resonant actuators of phones resonate at 150 to 200 Hz. A
choice."""


@dataclass(frozen=True)
class FrequencySpan:
    """Frequencies (Hz) at a file's 0 and 1 of frequency or sharpness, linear in between."""

    low: float
    high: float

    def share(self, hz: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Return the position of frequencies in the span, clipped to 0 to 1."""
        return np.clip((np.asarray(hz) - self.low) / (self.high - self.low), 0, 1)

    def hz(self, share: NDArray[np.float64] | float) -> NDArray[np.float64]:
        """Return the frequencies of shares."""
        return np.asarray(self.low + np.asarray(share) * (self.high - self.low))


@dataclass(frozen=True)
class Pulse:
    """A moment too short for the envelope.

    ``time`` (s) is its beginning; ``amplitude`` its initial amplitude, added to the envelope; ``frequency`` in Hz.
    """

    time: float
    amplitude: float
    frequency: float


@dataclass(frozen=True, eq=False)
class Envelope:
    """Amplitude and frequency (Hz) of a vibration over time (s), linear between points: float64 arrays, shape (point,).

    Times are non-decreasing, and the same time twice is a jump. The amplitude is that of the sine of equal power, 0
    outside the times; the frequency is constant outside its times.
    """

    seconds: float
    times: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    frequency_times: NDArray[np.float64]
    frequency: NDArray[np.float64]
    pulses: tuple[Pulse, ...] = ()

    @property
    def peak(self) -> float:
        """The largest amplitude, pulses included."""
        highest = float(self.amplitude.max(initial=0.0))
        for pulse in self.pulses:
            below = float(np.interp(pulse.time, self.times, self.amplitude))
            highest = max(highest, below + pulse.amplitude)
        return highest

    def scaled(self, factor: float) -> Envelope:
        """Return it with all amplitudes multiplied."""
        pulses = tuple(replace(pulse, amplitude=factor * pulse.amplitude) for pulse in self.pulses)
        return replace(self, amplitude=factor * self.amplitude, pulses=pulses)


def envelope_of(
    signal: Signal, *, low: float = 0.0, high: float = HIGHEST_HZ, step: float = STEP_S, pulses: bool = True
) -> Envelope:
    """Return the envelope of a signal of one axis over time, every ``step`` s.

    The power of the analytic signal (Gabor 1946) above ``low`` and up to ``high`` Hz, averaged over `WINDOW_S`; the
    frequency is the phase of the analytic signal's autocorrelation at a lag of one sample, averaged over
    `FREQUENCY_WINDOW_S`: the mean frequency, exact for a sine. With ``pulses``, moments too short for the envelope
    are extracted, and the envelope is reduced there so that both together keep the energy. Raises `ParameterError` if
    there are several axes, or the signal is over displacement.
    """
    if len(signal.axes) != 1:
        raise ParameterError(f"an envelope needs one axis, got {', '.join(signal.axes)}; choose one")
    if signal.domain != "time":
        raise ParameterError("an envelope is over time: convert the displacement at a speed first (play_at)")
    z, rate = _analytic(signal, low, high)
    times = np.concatenate([[0.0], np.arange(step, signal.seconds - step / 2, step), [signal.seconds]])
    power = np.abs(z) ** 2
    amplitude = np.sqrt(_at(_averaged(power, WINDOW_S * rate), times * rate))
    frequency = _frequency(z, rate, times, amplitude)
    if not pulses:
        return Envelope(signal.seconds, times, amplitude, times, frequency)
    found, ducked = _pulses(power, rate, signal.seconds, times, amplitude, frequency)
    return Envelope(signal.seconds, times, ducked, times, frequency, found)


def carrier(envelope: Envelope, rate: float | None = None) -> Signal:
    """Return a vibration with this envelope: a sine that follows its frequency and amplitude, of unit 1.

    ``rate`` is `READ_RATE` by default. Raises `ParameterError` if ``rate`` leaves no sample, or is too low for the
    carrier.
    """
    rate = rate or READ_RATE
    count = sample_count(envelope.seconds, rate)
    if count < 1:
        raise ParameterError(f"{envelope.seconds:g} s at {rate:g} Hz leave no sample; use a higher rate")
    t = np.arange(count) / rate
    amplitude = np.interp(t, envelope.times, envelope.amplitude, left=0.0, right=0.0)
    frequency = np.interp(t, envelope.frequency_times, envelope.frequency)
    highest = max(frequency.max(), *(p.frequency for p in envelope.pulses), 0.0)
    if highest >= rate / 2:
        raise ParameterError(f"a carrier of {highest:g} Hz needs more than {2 * highest:g} Hz, got {rate:g}")
    phase = 2 * np.pi * (np.cumsum(frequency) - frequency) / rate
    x = amplitude * np.sin(phase)
    for pulse in envelope.pulses:
        first = min(count - 1, max(0, math.ceil(pulse.time * rate)))
        last = min(count, first + math.ceil(PULSE_S * rate))
        away = t[first:last] - t[first]
        # In phase with the continuous vibration, so that the two add up.
        swing = np.sin(phase[first] + 2 * np.pi * pulse.frequency * away)
        x[first:last] += pulse.amplitude * pulse_shape(away) * swing
    return Signal(x.astype(np.float32), rate, "1")


def pulse_shape(seconds: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a pulse of amplitude 1 at times after its beginning, s."""
    return np.asarray(np.where(seconds >= 0, np.cos(np.pi / 2 * np.clip(seconds / PULSE_S, 0, 1)) ** 2, 0.0))


def stepped_envelope(edges: NDArray[np.float64], strength: NDArray[np.float64], hz: float) -> Envelope:
    """Return the envelope that is constant between ``edges`` (s), at one frequency."""
    return Envelope(
        float(edges[-1]),
        np.repeat(edges, 2)[1:-1],
        np.repeat(strength, 2),
        np.array([0.0]),
        np.array([hz]),
    )


def stepped_strength(
    signal: Signal,
    step_ms: int,
    bands: Sequence[tuple[float, float]],
    *,
    what: str,
    first_ms: int | None = None,
) -> tuple[NDArray[np.int64], list[NDArray[np.float64]]]:
    """Return the edges of steps of ``step_ms`` (ms, the last step shorter), and each band's strength in the steps.

    A strength is the envelope's amplitude in the middle of a step, at most 1. The first step lasts ``first_ms``,
    ``step_ms`` by default. ``what`` names the result in errors. Raises `ParameterError` if the signal is shorter than
    1 ms.
    """
    length = round(1e3 * signal.seconds)
    if length < 1:
        raise ParameterError(f"{what} needs at least 1 ms, got {signal.seconds:g} s")
    edges = np.unique([0, *range(first_ms or step_ms, length, step_ms), length])
    middles = (edges[:-1] + edges[1:]) / 2e3
    envelopes = [envelope_of(signal, low=low, high=high, pulses=False) for low, high in bands]
    return edges, [np.minimum(np.interp(middles, one.times, one.amplitude), 1) for one in envelopes]


def densified(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times with others between those more than two steps (`STEP_S`) apart."""
    gaps = np.diff(times)
    between = [
        np.linspace(times[i], times[i + 1], int(np.ceil(gaps[i] / STEP_S)), endpoint=False)[1:]
        for i in np.flatnonzero(gaps > 2 * STEP_S)
    ]
    return np.sort(np.concatenate([times, *between]))


def thinned(times: NDArray[np.float64], values: NDArray[np.float64], tolerance: float) -> NDArray[np.intp]:
    """Return the indices of points whose connecting lines stay within ``tolerance`` of all points.

    Douglas & Peucker (1973) with vertical distances, in pieces of `LONGEST_PIECE` points; includes the first and the
    last.
    """
    chosen = {0, len(times) - 1, *range(0, len(times), LONGEST_PIECE)}
    stack = list(pairwise(sorted(chosen)))
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        inside = slice(first + 1, last)
        line = np.interp(times[inside], times[[first, last]], values[[first, last]])
        error = np.abs(values[inside] - line)
        worst = int(np.argmax(error))
        if error[worst] > tolerance:
            middle = first + 1 + worst
            chosen.add(middle)
            stack += [(first, middle), (middle, last)]
    return np.array(sorted(chosen))


def _analytic(signal: Signal, low: float, high: float) -> tuple[NDArray[np.complex128], float]:
    """Return the analytic signal within a band at a rate of 4 `HIGHEST_HZ` or the signal's own, and that rate.

    The signal is continued by its mirror image, so that the ends make no step.
    """
    x = signal.samples[0].astype(np.float64)
    length = 2 * len(x)
    spectrum: NDArray[np.complex128] = fft.rfft(np.concatenate([x, x[::-1]]))
    frequency = np.arange(len(spectrum)) * signal.rate / length
    used = (frequency > low) & (frequency <= high)
    last = int(np.flatnonzero(used)[-1]) if used.any() else 0
    points = length
    if signal.rate > 4 * HIGHEST_HZ:
        points = fft.next_fast_len(max(2, last + 1, round(length * 4 * HIGHEST_HZ / signal.rate)))
    padded = np.zeros(points, np.complex128)
    padded[: last + 1] = 2 * np.where(used[: last + 1], spectrum[: last + 1], 0)
    z: NDArray[np.complex128] = fft.ifft(padded) * (points / length)
    rate = signal.rate * points / length
    return z[: max(1, round(points / 2))], rate


def _averaged(x: NDArray[np.float64], width: float) -> NDArray[np.float64]:
    """Return ``x`` averaged under a Hann window of ``width`` samples, shortened at the ends; >= 0."""
    n = max(1, 2 * round(width / 2) - 1)
    window = np.hanning(n + 2)[1:-1]
    if n == 1:
        return x
    if len(x) < n:
        window = window[(n - 1) // 2 - (len(x) - 1) // 2 :][: len(x)]
    total = scipy.signal.oaconvolve(np.ones(len(x)), window, mode="same")
    return np.asarray(np.maximum(scipy.signal.oaconvolve(x, window, mode="same") / total, 0))


def _at(x: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.interp(places, np.arange(len(x)), x))


def _frequency(
    z: NDArray[np.complex128], rate: float, times: NDArray[np.float64], amplitude: NDArray[np.float64]
) -> NDArray[np.float64]:
    loud = amplitude > QUIET * amplitude.max(initial=0.0)
    if len(z) < 2 or not loud.any():
        return np.full(len(times), UNKNOWN_HZ)
    lag = np.conj(z[:-1]) * z[1:]
    width = FREQUENCY_WINDOW_S * rate
    n = max(1, min(len(lag), 2 * round(width / 2) - 1))
    window = np.hanning(n + 2)[1:-1]
    smooth = scipy.signal.oaconvolve(lag, window, mode="same") if n > 1 else lag
    turning = np.maximum(np.angle(smooth), 0) * rate / (2 * np.pi)
    frequency = _at(turning, times * rate)
    return np.asarray(np.interp(times, times[loud], frequency[loud]))


def _pulses(
    power: NDArray[np.float64],
    rate: float,
    seconds: float,
    times: NDArray[np.float64],
    amplitude: NDArray[np.float64],
    frequency: NDArray[np.float64],
) -> tuple[tuple[Pulse, ...], NDArray[np.float64]]:
    """Return the onsets that are faster than the envelope can follow, and the envelope reduced at these moments."""
    at = np.arange(0, seconds, FINE_STEP_S)
    fine = np.sqrt(_at(_averaged(power, FINE_WINDOW_S * rate), at * rate))
    least = PULSE_SHARE * fine.max(initial=0.0)
    if len(at) < 3 or least == 0:
        return (), amplitude
    coarse = np.interp(at, times, amplitude)
    missing = fine - coarse
    # A pulse may be the very first moment, which is a peak only after silence.
    peaks, _ = scipy.signal.find_peaks(
        np.concatenate([[0.0], missing, [0.0]]),
        height=least,
        distance=max(1, round(PULSE_DISTANCE_S / FINE_STEP_S)),
    )
    peaks = peaks - 1
    ago = round(WINDOW_S / FINE_STEP_S)
    before = np.where(peaks >= ago, fine[np.maximum(peaks - ago, 0)], 0.0)
    peaks = peaks[fine[peaks] - before >= fine[peaks] / 2]
    ducked = amplitude.copy()
    found = []
    for i in peaks:
        inside = slice(max(0, i - round(DUCKED_BEFORE_S / FINE_STEP_S)), i + round(PULSE_S / FINE_STEP_S))
        share, strength = _shared(coarse[inside], float(coarse[i]), float(missing[i]), at[inside] - at[i])
        ducked[(times >= at[inside][0]) & (times <= at[inside][-1])] *= share
        found.append(Pulse(float(at[i]), strength, float(np.interp(at[i], times, frequency))))
    return tuple(found), ducked


def _shared(
    coarse: NDArray[np.float64], here: float, missing: float, away: NDArray[np.float64]
) -> tuple[float, float]:
    """Return the envelope's remaining share (0 to 1) and the pulse's strength that together keep the energy.

    A pulse is no stronger than the remaining envelope: files that multiply the two could not hold it.
    """
    shape = pulse_shape(away)
    energy, pulse = float(coarse @ coarse), missing**2 * float(shape @ shape)
    cross = missing * float(coarse @ shape)
    under = cross**2 - energy * (pulse - energy)
    share = (math.sqrt(under) - cross) / energy if under > 0 else 0.0
    if share * here >= missing:
        return min(1.0, share), missing
    share = math.sqrt(energy / float(np.sum((coarse + here * shape) ** 2)))
    return share, share * here
