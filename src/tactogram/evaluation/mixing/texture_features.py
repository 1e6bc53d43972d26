"""Features that locate a mix between its ends: third-octave levels and modulation depths, in dB."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import detrend, hilbert, periodogram, welch

from tactogram.evaluation.measures.bands import band_sums, felt_edges
from tactogram.evaluation.measures.sets import check_alike, segments
from tactogram.signal import Signal
from tactogram.signal.filters import bandpass

SEGMENT_S = 0.5
"""Length of the segments of a spectrum, s: bins of 2 Hz, about one in the narrowest band."""
CARRIERS_HZ = ((20.0, 100.0), (100.0, 1000.0))
"""Bands whose envelopes are computed: roughly those of the rapidly adapting and the Pacinian channel."""
MODULATIONS_HZ = (2.0, 4.0, 8.0, 16.0, 32.0)
"""Octave bands of the envelopes."""
POWER_FLOOR, DEPTH_FLOOR = 1e-14, 1e-5
"""Added to powers (unit²) and to modulation (a share of the mean, squared), so that silence has a level."""


def texture_features(signals: Sequence[Signal], *, level: bool = True) -> NDArray[np.float64]:
    """Return features of each signal's texture that do not depend on phase, in dB.

    Per axis: the level in each third-octave band that is felt (Welch 1967); then the depth of modulation of the
    envelope of each of `CARRIERS_HZ` in each of `MODULATIONS_HZ`, 10 log10 of the envelope's variance in that
    band over its squared mean. The logarithm of a noisy power has a bias that depends on the amount of data:
    signals are therefore cut to pieces as long as the shortest of them, and features are means over pieces.

    Without ``level``, the levels of an axis are relative to its power in all bands. Raises `ParameterError` if signals
    differ in rate, unit or axes, are not over time, or one is shorter than `SEGMENT_S`.

    Returns
    -------
    float64 array, shape (signal, axis, feature), dB
    """
    seconds = min((signal.seconds for signal in signals), default=0.0)
    check_alike(signals, shortest_s=max(SEGMENT_S, seconds))
    return np.array([np.mean([_features(p, level) for p in segments([s], seconds)], axis=0) for s in signals])


def _features(signal: Signal, level: bool) -> NDArray[np.float64]:
    depths = [_depths(signal, *carrier) for carrier in _carriers(signal.rate)]
    return np.concatenate([_levels(signal, level), *depths], axis=1)


def _levels(signal: Signal, level: bool) -> NDArray[np.float64]:
    """Return the level in each band, dB re 1 unit², float64, shape (axis, band)."""
    f, density = welch(signal.samples.astype(np.float64), signal.rate, nperseg=round(SEGMENT_S * signal.rate))
    powers = band_sums(density * f[1], f, felt_edges(signal.rate))
    decibels: NDArray[np.float64] = 10 * np.log10(powers + POWER_FLOOR)
    if not level:
        decibels -= 10 * np.log10(powers.sum(axis=1, keepdims=True) + POWER_FLOOR)
    return decibels


def _carriers(rate: float) -> list[tuple[float, float]]:
    """Return the bands of which a signal of ``rate`` Hz contains at least an octave."""
    cut = [(low, min(high, 0.45 * rate)) for low, high in CARRIERS_HZ]
    return [(low, high) for low, high in cut if high >= 2 * low]


def _depths(signal: Signal, low: float, high: float) -> NDArray[np.float64]:
    """Return the depth of modulation of one carrier band in dB, float64, shape (axis, modulation band)."""
    envelope = np.abs(hilbert(bandpass(signal, low, high).samples.astype(np.float64), axis=1))
    relative = envelope / (envelope.mean(axis=1, keepdims=True) + np.sqrt(POWER_FLOOR))
    f, density = periodogram(detrend(relative, type="constant"), signal.rate, "hann")
    known = [c for c in MODULATIONS_HZ if c / np.sqrt(2) >= 1.5 / signal.seconds]
    edges = np.array([c / np.sqrt(2) for c in (*known, 2 * known[-1])]) if known else np.empty(0)
    depth = band_sums(density * f[1], f, edges) if known else np.empty((len(envelope), 0))
    return np.asarray(10 * np.log10(depth + DEPTH_FLOOR))
