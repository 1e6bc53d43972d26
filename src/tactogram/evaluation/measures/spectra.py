"""Spectra of sets of signals: power, in bands as they are felt, and modulation of envelopes.

Two textures of one spectrum feel different when one is even and the other comes in bursts, ridges or slips. A
power spectrum cannot show that; the spectrum of an envelope can.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft
from scipy.signal import sosfiltfilt, welch
from scipy.special import digamma

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.measure import once_per_set, stacks
from tactogram.signal import Signal
from tactogram.signal.filters import butterworth
from tactogram.signal.perception import FELT_HZ, detection_threshold

SEGMENT_S = 0.25
"""Length of the segments that a spectrum is averaged over, s: bins of 4 Hz."""

BAND_HZ = (10.0, 1000.0)
"""Compared by default: below is movement and drift, above hardly anything is felt."""

SILENT = 1e-30
"""Power that replaces zero in logarithms."""
MODULATION_HZ = (2.0, 100.0)
"""Slower is how the hand moves, faster is felt as frequency rather than fluctuation."""
WINDOW_S = 1.0
"""Length of the Hann windows that an envelope's spectrum is averaged over, s. Shorter signals shorten the window to
their length, and the slowest modulation included is then 2 / length."""
SHORTEST_S = 0.5
"""Minimum length of signals, s."""
MODULATION_FLOOR_DB = -40.0
"""Less modulation in a band counts as this: a depth of 1.4 %, which nobody feels."""
THRESHOLD_UNITS = ("m", "m/s", "m/s^2")
"""Units with a known detection threshold."""
FELT_LIKE = {"N": "m", "V": "m/s^2", "1": "m/s^2"}
"""Units without a threshold of their own, and the unit whose threshold curve they borrow: its shape, not its level.

Skin is elastic below some 100 Hz, so force follows displacement; the sound of a surface follows its
acceleration, and so do most sensors that give volts or counts."""
FELT_RANGE_DB = 50.0
"""Bands farther than this below the strongest are not counted, whatever the unit. About the range from
the threshold to the unpleasant, which is general knowledge of the field and was not checked in a source."""
UNCERTAIN_DB = 20.0
"""By how much people and contactors may be more sensitive than the threshold curve: some people feel a grasped cylinder
at a tenth of its minimum (see `tactogram.signal.perception`)."""
DRIFT_HZ = 10.0
"""Slower components are movement and drift and would outweigh the vibration."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Power spectra of a set, in the order of `stacks`."""

    frequency: NDArray[np.float64]
    """Shape (frequency,), Hz."""
    power: NDArray[np.float64]
    """One-sided, shape (signal, axis, frequency), unit^2/Hz."""
    independent: NDArray[np.float64]
    """Number of independent segments in each average, shape (signal,)."""


@once_per_set
def power_spectra(signals: Sequence[Signal]) -> Spectra:
    """Return the power spectra of ``signals`` (Welch, Hann segments of `SEGMENT_S`, half overlapping)."""
    rate = signals[0].rate
    length = round(SEGMENT_S * rate)
    if length < 4:
        raise ParameterError.must("rate", f"be at least {4 / SEGMENT_S:g} Hz for a spectrum", rate)
    powers, independent = [], []
    for stack in stacks(signals):
        frequency, power = welch(stack, rate, nperseg=length, axis=-1)
        powers.append(power)
        count = (stack.shape[-1] - length // 2) // (length - length // 2)
        # Hann windows that overlap by half share (1/6)^2 of their power's variance.
        independent += [count / (1 + 2 * (count - 1) / count / 36)] * len(stack)
    return Spectra(frequency, np.concatenate(powers), np.array(independent))


def mean_spectrum_db(power: NDArray[np.float64], independent: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean over signals in dB, unbiased, shape (axis, frequency).

    ``independent`` is the number of independent estimates in each power, shape (signal, ...).
    """
    bias = 10 / np.log(10) * (digamma(independent) - np.log(independent))
    bias = bias.reshape(len(power), 1, -1)
    return np.asarray(np.mean(10 * np.log10(np.maximum(power, SILENT)) - bias, axis=0))


def check_band(frequency: NDArray[np.float64], band: tuple[float, float]) -> NDArray[np.bool_]:
    """Return which frequencies lie in ``band``; refuse a band without any."""
    inside = (frequency >= band[0]) & (frequency <= band[1])
    if not inside.any():
        raise ParameterError.must(
            "band", f"hold a frequency below {frequency[-1]:g} Hz, got {band[0]:g} {band[1]:g} Hz"
        )
    return inside


def envelopes(
    stack: NDArray[np.float64],
    rate: float,
    low: float,
    high: float,
    gain: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> tuple[NDArray[np.float64], float]:
    """Return the Hilbert envelopes of a band, shape (..., time), >= 0, and their rate, just high enough for them.

    The magnitude of the analytic signal (Gabor 1946); of a sine its amplitude. Only the bins of the band are
    transformed back: a shift in frequency changes no magnitude, so a narrow band costs little. The signal is extended
    by its mirror image, which avoids steps at its ends.

    The band ``low`` to ``high``, Hz, is cut at half the rate; ``gain`` is its factor per frequency, Hz. The new rate is
    at least twice the band's width and four times the fastest modulation, where the signal has that much.
    """
    length = 2 * stack.shape[-1]
    spectrum = fft.rfft(np.concatenate([stack, stack[..., ::-1]], axis=-1), axis=-1)
    first = max(1, int(np.ceil(low * length / rate)))
    last = min(length // 2 - 1, int(np.floor(high * length / rate)))
    band = spectrum[..., first : last + 1] * gain(np.arange(first, last + 1) * rate / length)
    needed = max(2 * (last + 1 - first), int(np.ceil(4 * MODULATION_HZ[1] * length / rate)))
    points = 2 * fft.next_fast_len(-(-needed // 2))
    analytic = fft.ifft(band, n=points, axis=-1)[..., : points // 2]
    return np.abs(analytic) * (2 * points / length), rate * points / length


def modulation_power(
    envelope: NDArray[np.float64], rate: float, window_s: float, edges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the power of an envelope's fluctuation around its mean of 1, summed in bands: shape (..., band).

    m^2 / 2 for a modulation of depth m; 0 for an envelope that is 0 throughout. Hann windows of ``window_s`` seconds,
    half overlapping (Welch 1967).
    """
    mean = envelope.mean(axis=-1, keepdims=True)
    relative = np.divide(envelope, mean, out=np.ones_like(envelope), where=mean > 0)
    length = min(envelope.shape[-1], round(window_s * rate))
    frequency, power = welch(relative, rate, nperseg=length, axis=-1)
    return np.asarray(band_sums(power, frequency, edges) * frequency[1])


def modulation_window(*sets: Sequence[Signal]) -> float:
    """Return the window length for all of ``sets``, s: `WINDOW_S`, or the shortest signal."""
    return min(WINDOW_S, *(signal.seconds for members in sets for signal in members))


def modulation_edges(rate: float, window: float, high: float, *, per_octave: int) -> NDArray[np.float64]:
    """Return the edges of modulation bands up to ``high``, as far as window and rate resolve them, Hz."""
    return band_edges(max(MODULATION_HZ[0], 2 / window), min(high, rate / 2), per_octave=per_octave)


def mean_modulation_db(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean over signals in dB, at least `MODULATION_FLOOR_DB`, shape (axis, band)."""
    floor = 10 ** (MODULATION_FLOOR_DB / 10)
    return np.asarray(np.mean(10 * np.log10(np.maximum(power, floor)), axis=0))


def band_edges(low: float, high: float, *, per_octave: int) -> NDArray[np.float64]:
    """Return edges spaced evenly on a logarithmic scale from ``low`` to ``high``, both included.

    ``per_octave`` is approximate: the number of bands is rounded. float64, shape (band + 1,), Hz.
    """
    if not 0 < low < high:
        raise ParameterError.must("band", f"be 0 < low < high in Hz, got {low:g} {high:g}")
    bands = max(1, round(np.log2(high / low) * per_octave))
    return np.geomspace(low, high, bands + 1)


def felt_edges(rate: float, *, per_octave: int = 3) -> NDArray[np.float64]:
    """Return the edges of the bands of `FELT_HZ` below half of ``rate``, Hz; errors as `check_felt`."""
    check_felt(rate)
    low, high = FELT_HZ
    return band_edges(low, min(high, rate / 2), per_octave=per_octave)


def check_felt(rate: float) -> None:
    """Refuse a ``rate`` in Hz that is too low for vibration."""
    if rate / 2 <= FELT_HZ[0]:
        raise ParameterError.must("rate", f"be above {2 * FELT_HZ[0]:g} Hz to hold vibration", rate)


def band_sums(
    values: NDArray[np.float64], frequency: NDArray[np.float64], edges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``values``, shape (..., frequency), summed in each band: float64, shape (..., band).

    ``frequency`` is evenly spaced from 0. A value covers one spacing around its frequency and is split between two
    bands at an edge, so no band is empty, however narrow. ``edges`` has shape (band + 1,), Hz.
    """
    spacing = frequency[1] - frequency[0]
    below = np.clip((edges[:, None] - frequency) / spacing + 0.5, 0, 1)
    return np.asarray(values @ np.diff(below, axis=0).T)


def felt_weight(frequency: ArrayLike, unit: str) -> NDArray[np.float64]:
    """Return the factor that turns a power at ``frequency``, > 0 Hz, into a multiple of the threshold's; same shape.

    For `THRESHOLD_UNITS` the weight is absolute: a sine whose *peak* is at the threshold gives 1/2, its mean square in
    units of the threshold's peak. For any other unit it is the shape of a related curve (`FELT_LIKE`), at most 1:
    levels are then only relative. Not limited to `FELT_HZ`.
    """
    weight = detection_threshold(frequency, FELT_LIKE.get(unit, unit)) ** -2.0
    return weight if unit in THRESHOLD_UNITS else weight / weight.max()


def felt_floor_db(unit: str, *levels: NDArray[np.float64]) -> float:
    """Return the level below which nothing is felt next to ``levels`` (dB re threshold), dB.

    `FELT_RANGE_DB` below the strongest, and never lower than `UNCERTAIN_DB` below the threshold (0 dB) where
    ``unit`` has one.
    """
    floor = max(float(level.max()) for level in levels) - FELT_RANGE_DB
    return max(floor, -UNCERTAIN_DB) if unit in THRESHOLD_UNITS else floor


def without_drift(stack: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """Return ``stack`` (..., time) high-passed at `DRIFT_HZ`, without its mean and without delay."""
    x = stack - stack.mean(axis=-1, keepdims=True)
    if rate / 2 <= DRIFT_HZ:
        return np.asarray(x)
    sos = butterworth(rate, DRIFT_HZ, np.inf, order=2, passes=2)
    pad = min(x.shape[-1] - 1, int(np.ceil(3 * rate / DRIFT_HZ)))
    return np.asarray(sosfiltfilt(sos, x, axis=-1, padtype="even" if pad else None, padlen=pad))
