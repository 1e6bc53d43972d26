"""Power spectra of sets of signals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch
from scipy.special import digamma

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.sets import stacks
from tactogram.signal import Signal

SEGMENT_S = 0.25
"""Length of the segments that a spectrum is averaged over, s: bins of 4 Hz."""

BAND_HZ = (10.0, 1000.0)
"""Compared by default: below is movement and drift, above hardly anything is felt."""

SILENT = 1e-30
"""Power that replaces zero in logarithms."""


@dataclass(frozen=True, eq=False)
class Spectra:
    """Power spectra of a set, in the order of `stacks`."""

    frequency: NDArray[np.float64]
    """Shape (frequency,), Hz."""
    power: NDArray[np.float64]
    """One-sided, shape (signal, axis, frequency), unit^2/Hz."""
    independent: NDArray[np.float64]
    """Number of independent segments in each average, shape (signal,)."""


def power_spectra(signals: Sequence[Signal]) -> Spectra:
    """Return the power spectra of ``signals`` (Welch, Hann segments of `SEGMENT_S`, half overlapping)."""
    rate = signals[0].rate
    length = round(SEGMENT_S * rate)
    if length < 4:
        raise ParameterError(f"rate must be at least {4 / SEGMENT_S:g} Hz for a spectrum, got {rate:g}")
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
        raise ParameterError(
            f"band must hold a frequency below {frequency[-1]:g} Hz, got {band[0]:g} {band[1]:g} Hz"
        )
    return inside
