"""Fitting of tones: the lines of recordings that follow one wandering speed, and what is left without them.

The strongest ridge of the short-time spectrum is tracked and its phase refined by demodulation. Resampled to constant
steps of that phase, every line that follows the speed is sharp. A ridge of noise can be tracked as well, but the line
that becomes of it is little stronger than the noise around it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from tactogram.signal.tones import STEP_S, Tones

Array = NDArray[np.float64]

WINDOW_S, HOPS = 0.25, 16
"""Window of the short-time spectrum, s, and hops in it."""
STEEPEST = 40.0
"""Slope of the ridge, Hz/s, that costs as much as e^1.1 times less power."""
BANDWIDTH_HZ, REFINEMENTS = 8.0, 2
"""Of the demodulation that refines the phase, and how often that is done."""
LEAST_LINE_HZ = 300.0
"""Power of the tracked line over the power density around it. Of noise, however narrow, it was at most 220."""
AROUND_HZ = (4.0, 15.0)
"""Distances that count as around it."""
STEADY, STEADY_HZ = 0.8, 4.0
"""Least share of the power within a bandwidth that other lines have."""
PROMINENT = 50.0
"""Least power of other lines over the median around them, of `AROUND` bins."""
AROUND = 61
GAIN_S = 0.033
"""Standard deviation of the Gaussian that smooths the gain of the lines: a bandwidth of 4 Hz."""
LAG_S = 0.1
"""At which autocorrelations are measured."""
LINES = 16
"""Most lines."""
LEAST_S = 0.5
"""Shorter recordings have no lines."""
LEAST_SHARE = 0.1
"""Of a recording's power, in lines."""
MULTIPLES = 6
"""Lines at n/m times the tracked one are taken for exactly there, up to this m."""


class StrokeLines(NamedTuple):
    """Lines of one recording: phase of the tracked one, cycles; gain; multiples; amplitudes; and the rest."""

    cycles: Array  # (time,)
    gain: Array  # (time,), mean square 1
    multiple: Array  # (line,)
    amplitude: NDArray[np.complex128]  # (axis, line)
    rest: Array  # (axis, time)

    @property
    def power(self) -> Array:
        """Of each axis, (axis,)."""
        return np.asarray(0.5 * np.sum(np.abs(self.amplitude) ** 2, axis=1))


def split_tones(
    recordings: Sequence[Array], rate: float, *, band: ArrayLike
) -> tuple[list[Tones], list[Array]]:
    """Return the tones of each recording of one texture that has some, and every recording without its own.

    If fewer than half of them have lines, there are none. All tones have the mean power of all recordings; the first
    are of the recording with the median share of power in its lines.

    Parameters
    ----------
    recordings : sequence of float64 array, shape (axis, time)
        Without their mean.
    rate : float, Hz
    band : array-like of float, Hz, shape (2,)
        Range of the lines.
    """
    limits = np.asarray(band, np.float64)
    all_lines = [stroke_lines(x, rate, band=limits) for x in recordings]
    having = [index for index, lines in enumerate(all_lines) if lines is not None]
    if 2 * len(having) < len(recordings) or not having:
        return [], list(recordings)
    strokes = {index: lines for index, lines in enumerate(all_lines) if lines is not None}
    share = {p: lines.power.sum() / np.mean(np.sum(recordings[p] ** 2, 0)) for p, lines in strokes.items()}
    median = sorted(having, key=share.__getitem__)[len(having) // 2]
    power = np.sum([each.power for each in strokes.values()], axis=0) / len(recordings)
    speeds, unsteadiness = _unsteadiness(list(strokes.values()), rate)
    tones = {}
    for (stroke, lines), speed in zip(strokes.items(), speeds, strict=True):
        scale = np.sqrt(power / np.maximum(lines.power, np.finfo(float).tiny)) * np.exp(
            -(unsteadiness[3] ** 2)
        )
        parts = np.stack((lines.amplitude.real, lines.amplitude.imag)) * scale[:, None]
        tones[stroke] = Tones(float(np.exp(speed)) * lines.multiple, parts, unsteadiness)
    first = [tones.pop(median)]
    return first + list(tones.values()), [
        x if index not in strokes else strokes[index].rest for index, x in enumerate(recordings)
    ]


def stroke_lines(x: Array, rate: float, *, band: Array) -> StrokeLines | None:
    """Return the lines of a recording, (axis, time), or None if its strongest ridge is not a tone."""
    if x.shape[1] < LEAST_S * rate:
        return None
    inside = scipy.signal.sosfiltfilt(
        scipy.signal.butter(2, band, "bandpass", fs=rate, output="sos"), x, axis=-1
    )
    if not inside.any():
        return None
    cycles = np.cumsum(_ridge(inside, rate, band)) / rate
    for _ in range(REFINEMENTS):
        slow = _demodulated(inside, cycles, rate, BANDWIDTH_HZ)
        strongest = slow[np.argmax(np.mean(np.abs(slow), axis=1))]
        cycles = cycles + np.unwrap(np.angle(strongest)) / (2 * np.pi)
    if _over_noise(inside, cycles, rate) < LEAST_LINE_HZ:
        return None
    multiple = _multiples(inside, cycles, rate)
    waves = np.exp(2j * np.pi * multiple[:, None] * cycles)  # line, time
    basis = np.concatenate((waves.real, -waves.imag))
    parts = np.linalg.lstsq(basis.T, x.T, rcond=None)[0].T  # axis, 2 lines
    gain = _gain(x, parts @ basis, rate)
    parts = np.linalg.lstsq((gain * basis).T, x.T, rcond=None)[0].T
    rest = x - gain * (parts @ basis)
    if np.sum(rest**2) > (1 - LEAST_SHARE) * np.sum(x**2):
        return None
    amplitude = parts[:, : len(multiple)] + 1j * parts[:, len(multiple) :]
    return StrokeLines(cycles, gain, multiple, amplitude, rest)


def _gain(x: Array, lines: Array, rate: float) -> Array:
    """Return the slow gain of lines, (axis, time), that fits a recording best, (time,), of mean square 1."""
    product, power = (
        scipy.ndimage.gaussian_filter1d(np.sum(each * lines, axis=0), GAIN_S * rate) for each in (x, lines)
    )
    gain = np.maximum(product / np.maximum(power, LEAST_SHARE * power.mean()), 0)
    return np.asarray(gain / np.sqrt(np.mean(gain**2)))


def _ridge(x: Array, rate: float, band: Array) -> Array:
    """Return the frequency of the strongest ridge at every sample, Hz, by dynamic programming."""
    size = max(HOPS, 2 * round(WINDOW_S * rate / 2))
    hop = size // HOPS
    padded = np.pad(x, ((0, 0), (size // 2, size // 2)), mode="reflect")
    pieces = np.lib.stride_tricks.sliding_window_view(padded, size, axis=1)[:, ::hop] * np.hanning(size)
    frequency = np.fft.rfftfreq(4 * size, 1 / rate)
    kept = (frequency >= band[0]) & (frequency <= band[1])
    power = np.sum(np.abs(np.fft.rfft(pieces, 4 * size)[..., kept]) ** 2, axis=0)  # frame, bin
    logs = np.log(power + 1e-9 * power.max())
    reach = max(2, round(STEEPEST * hop / rate / (frequency[1] - frequency[0])))
    steps = np.arange(-reach, reach + 1)
    total, back = logs[0], np.zeros(logs.shape, np.intp)
    bins = np.arange(logs.shape[1])
    for frame in range(1, len(logs)):
        from_below = bins - steps[:, None]
        inside = (from_below >= 0) & (from_below < len(bins))
        reached = np.where(inside, total[np.clip(from_below, 0, len(bins) - 1)], -np.inf)
        reached = reached - 1.125 * (steps[:, None] / reach) ** 2
        best = np.argmax(reached, axis=0)
        back[frame] = bins - steps[best]
        total = reached[best, bins] + logs[frame]
    path = np.zeros(len(logs), np.intp)
    path[-1] = np.argmax(total)
    for frame in range(len(logs) - 1, 0, -1):
        path[frame - 1] = back[frame, path[frame]]
    return np.asarray(np.interp(np.arange(x.shape[1]), np.arange(len(logs)) * hop, frequency[kept][path]))


def _demodulated(x: Array, cycles: Array, rate: float, bandwidth: float) -> NDArray[np.complex128]:
    """Return the slow amplitude, (axis, time), of a line of the phase ``cycles``."""
    low_pass = scipy.signal.butter(2, bandwidth, fs=rate, output="sos")
    amplitude: NDArray[np.complex128] = scipy.signal.sosfiltfilt(
        low_pass, x * np.exp(-2j * np.pi * cycles), axis=-1
    )
    return amplitude


def _over_noise(x: Array, cycles: Array, rate: float) -> float:
    """Return the power of a line over the median power density around it, Hz."""
    count = x.shape[1]
    wave = np.exp(-2j * np.pi * cycles) * np.hanning(count)
    power = np.sum(np.abs(np.fft.fft(x * wave, axis=1)) ** 2, axis=0)
    distance = np.abs(np.fft.fftfreq(count, 1 / rate))
    around = np.median(power[(distance > AROUND_HZ[0]) & (distance < AROUND_HZ[1])])
    return float(power[distance < 3 * rate / count].sum() / max(around, np.finfo(float).tiny) * rate / count)


def _steadiness(slow: NDArray[np.complex128]) -> float:
    """Return the share of the power of slow amplitudes that is constant, the ends left out."""
    ends = slow.shape[1] // 20
    middle = slow[:, ends : slow.shape[1] - ends]
    return float(np.sum(np.abs(middle.mean(1)) ** 2) / np.sum(np.mean(np.abs(middle) ** 2, axis=1)))


def _multiples(x: Array, cycles: Array, rate: float) -> Array:
    """Return the multiples of a tracked line, 1 first, at which there are others that follow it."""
    total = cycles[-1] - cycles[0]
    times = np.arange(x.shape[1])
    even = np.interp(np.linspace(cycles[0], cycles[-1], len(times)), cycles, times)
    warped = scipy.interpolate.make_interp_spline(times, x, axis=1)(even)
    power = np.sum(np.abs(np.fft.rfft(warped * np.hanning(len(times)))) ** 2, axis=0)
    median = scipy.ndimage.median_filter(power, size=AROUND)
    peaks = scipy.signal.find_peaks(power)[0]
    peaks = peaks[(power[peaks] > PROMINENT * median[peaks]) & (peaks > 2)]
    peaks = peaks[np.argsort(-power[peaks], kind="stable")]
    multiples = [1.0]
    for peak in peaks:
        before, top, after = np.log(power[peak - 1 : peak + 2])
        multiple = (peak + 0.5 * (before - after) / (before - 2 * top + after)) / total
        if min(abs(multiple - other) for other in multiples) * total < 4:
            continue
        slow = _demodulated(x, multiple * cycles, rate, STEADY_HZ)
        if _steadiness(slow) < STEADY:
            continue
        near = [
            n / m
            for m in range(1, MULTIPLES + 1)
            if abs((n := round(m * multiple)) / m - multiple) * total < 0.5
        ]
        multiples.append(near[0] if near else multiple)
        if len(multiples) == LINES:
            break
    return np.array(multiples)


def _unsteadiness(strokes: Sequence[StrokeLines], rate: float) -> tuple[Array, Array]:
    """Return the mean logarithm of each recording's speed, Hz of its tracked line, and `Tones.unsteadiness`."""
    low_pass = scipy.signal.butter(2, BANDWIDTH_HZ, fs=rate, output="sos")
    speeds, gains = [], []
    for each in strokes:
        hz = scipy.signal.sosfiltfilt(low_pass, np.gradient(each.cycles) * rate)
        middle = slice(len(hz) // 20, len(hz) - len(hz) // 20)
        speeds.append(np.log(np.maximum(hz[middle], 1e-3)))
        gains.append(np.log(np.maximum(each.gain[middle], 1e-3)))
    means = np.array([each.mean() for each in speeds])
    # Recordings may track different lines: the median deviation is that of those with the same.
    between = min(1.4826 * np.median(np.abs(means - np.median(means))), 0.2)
    within = [number for logs in (speeds, gains) for number in _process(logs, round(LAG_S * rate))]
    return means, np.array([between, *within])


def _process(logs: Sequence[Array], lag: int) -> tuple[float, float]:
    """Return the median standard deviation over recordings, and the autocorrelation over `STEP_S`."""
    centred = [each - each.mean() for each in logs if len(each) > 2 * lag]
    if not centred:
        return 0.0, 0.0
    deviation = np.array([each.std() for each in centred])
    kept = [np.mean(x[lag:] * x[:-lag]) / max(sd**2, 1e-12) for x, sd in zip(centred, deviation, strict=True)]
    return float(np.median(deviation)), float(np.clip(np.median(kept), 1e-3, 0.9999) ** (STEP_S / LAG_S))
