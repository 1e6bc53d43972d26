"""Local amplitudes: distributions of samples divided by the level around them, which clicks and slips give long tails.

Noise with a recorded spectrum and recorded levels still lacks the clicks within a level: its samples, divided by their
running rms, are nearly normal. Those of recordings are not. So the quantiles of made ones are mapped to the recorded
quantiles and their level is put back, over windows of several lengths; their spectrum is restored after each.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]

WINDOWS_S = (0.2, 0.05, 0.0125)
"""Of the running rms, s, in the order in which samples are mapped."""
LEVELS = scipy.special.ndtr(np.linspace(-4, 4, 41))
"""Of the quantiles, evenly spaced normal scores: beyond lie 3 of 100,000 samples on each side."""
SEGMENT_S = 0.25
"""Segments of the spectra that are compared, s: bins of 4 Hz."""


def local_quantiles(recordings: Sequence[NDArray[np.floating]], rate: float) -> Array:
    """Return the recorded quantiles at `LEVELS`, float64, shape (axis, window, quantile), ascending along the last.

    ``recordings``, each (axis, time) at ``rate`` (Hz), have mean 0 and no tones. A weighted mean of the quantiles of
    several textures is that of a texture between them (a Wasserstein barycentre).
    """
    local = [np.hstack([x / _running_rms(x, rate, window) for x in recordings]) for window in WINDOWS_S]
    return np.asarray(np.moveaxis(np.quantile(local, LEVELS, axis=-1), (0, 1), (2, 1)), np.float64)


def with_local_quantiles(samples: NDArray[np.floating], rate: float, quantiles: Array) -> Array:
    """Return made samples, (axis, time) with mean 0, with the local amplitudes of recordings and their own spectrum.

    Those shorter than the longest of `WINDOWS_S` stay as they are.
    """
    x = y = np.asarray(samples, np.float64)
    if x.shape[1] < WINDOWS_S[0] * rate:
        return x
    for number, window in enumerate(WINDOWS_S):
        level = _running_rms(y, rate, window)
        local = y / level
        own = np.quantile(local, LEVELS, axis=1).T
        recorded = [np.interp(*each) for each in zip(local, own, quantiles[:, number], strict=True)]
        y = _with_spectrum_of(x, level * recorded, rate)
    return y


def _running_rms(x: NDArray[np.floating], rate: float, window: float) -> Array:
    power = np.square(x, dtype=np.float64)
    size = max(1, round(window * rate))
    mean = scipy.ndimage.uniform_filter1d(power, size, axis=1, mode="nearest")
    least = 1e-12 * power.mean(axis=1, keepdims=True) + np.finfo(float).tiny
    return np.asarray(np.sqrt(np.maximum(mean, least)))


def _with_spectrum_of(x: Array, y: Array, rate: float) -> Array:
    """Return ``y`` filtered, without delay, to the power spectrum of ``x``, and without a mean."""
    segment = min(x.shape[1], round(SEGMENT_S * rate))
    target_power, power = (scipy.signal.welch(each, rate, nperseg=segment)[1] for each in (x, y))
    gain = np.sqrt(target_power / np.maximum(power, np.finfo(float).tiny))
    spectrum = np.fft.rfft(y)
    bins = np.linspace(0, gain.shape[1] - 1, spectrum.shape[1])
    spectrum *= [np.interp(bins, np.arange(len(row)), row) for row in gain]
    spectrum[:, 0] = 0
    return np.fft.irfft(spectrum, x.shape[1])
