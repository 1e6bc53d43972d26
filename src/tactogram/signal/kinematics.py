"""Kinematics: acceleration to velocity to displacement, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tactogram.errors import ParameterError, UnitError
from tactogram.signal.filters import butterworth
from tactogram.signal.signal import Signal

_INTEGRAL = {"m/s^2": "m/s", "m/s": "m"}
_DERIVATIVE = {unit: base for base, unit in _INTEGRAL.items()}


def integrate(signal: Signal, *, below: float = 5.0) -> Signal:
    """Return the velocity of an acceleration, or the displacement of a velocity, without drift.

    Integration turns the least offset into a ramp, so what is slower than ``below`` is given up: a zero-phase
    Butterworth high-pass of order 4, at -3 dB at ``below`` (and the mean). Above it the integral is exact
    in level and phase up to half the rate: it is taken in the spectrum of the signal mirrored at its ends,
    not by a running sum. Within one period of ``below`` of the ends it is less certain.
    The mean of the result is 0; a displacement is relative.

    Parameters
    ----------
    signal : Signal
        In m/s^2 or m/s, over time.
    below : float, Hz
        > 0 and below half the rate.

    Returns
    -------
    Signal
        In m/s or m, of the same length.

    Raises
    ------
    UnitError
        For any other unit.
    ParameterError
        If ``below`` is out of range, or the signal is not over time or shorter than one period of ``below``.
    """
    unit = _changed(signal, _INTEGRAL, "integrated")
    if not below > 0:
        raise ParameterError(f"below must be > 0 Hz, got {below:g}")
    if signal.seconds * below < 1:
        raise ParameterError(
            f"signal must last one period of {below:g} Hz, got {signal.seconds:g} s; raise below"
        )
    n = len(signal)
    x = signal.samples.astype(np.float64)
    x = np.concatenate([x, x[:, ::-1]], axis=1)
    spectrum = fft.rfft(x, axis=1)
    frequency = fft.rfftfreq(2 * n, 1 / signal.rate)
    operator = np.zeros(len(frequency), dtype=np.complex128)
    operator[1:] = _highpass(signal.rate, below, frequency[1:]) / (2j * np.pi * frequency[1:])
    return signal.with_samples(fft.irfft(spectrum * operator, n=2 * n, axis=1)[:, :n], unit=unit)


def differentiate(signal: Signal) -> Signal:
    """Return the velocity of a displacement, or the acceleration of a velocity.

    Exact up to half the rate, in the spectrum of the signal continued by point reflection at its ends (so that
    value and slope go on there). It amplifies noise with frequency: band-limit first.

    Parameters
    ----------
    signal : Signal
        In m or m/s, over time, at least two samples.

    Returns
    -------
    Signal
        In m/s or m/s^2, of the same length.

    Raises
    ------
    UnitError
        For any other unit.
    ParameterError
        If the signal is not over time or has one sample only.
    """
    unit = _changed(signal, _DERIVATIVE, "differentiated")
    n = len(signal)
    if n < 2:
        raise ParameterError("signal must have at least two samples to be differentiated, got 1")
    x = signal.samples.astype(np.float64)
    slope = (x[:, -1:] - x[:, :1]) / (n - 1)
    x = x - x[:, :1] - slope * np.arange(n)
    x = np.concatenate([x, -x[:, -2:0:-1]], axis=1)
    spectrum = fft.rfft(x, axis=1) * 2j * np.pi * fft.rfftfreq(x.shape[1], 1 / signal.rate)
    y = fft.irfft(spectrum, n=x.shape[1], axis=1)[:, :n] + slope * signal.rate
    return signal.with_samples(y, unit=unit)


def _changed(signal: Signal, units: dict[str, str], verb: str) -> str:
    if signal.unit not in units:
        raise UnitError(f"only {' and '.join(units)} can be {verb}, got {signal.unit}")
    if signal.domain != "time":
        raise ParameterError(f"a signal over displacement cannot be {verb} over time")
    return units[signal.unit]


def _highpass(rate: float, below: float, frequency: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the gain of a Butterworth high-pass run forward and backward, at -3 dB at ``below``."""
    sos = butterworth(rate, below, np.inf, passes=2)
    z = np.exp(-2j * np.pi * frequency / rate)
    gain = np.ones_like(z)
    for b0, b1, b2, _, a1, a2 in sos:
        gain *= (b0 + (b1 + b2 * z) * z) / (1 + (a1 + a2 * z) * z)
    return np.asarray(np.abs(gain) ** 2)
