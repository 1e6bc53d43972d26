"""Filters of whole signals: band-pass, three axes to one, derivative."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import ParameterError, UnitError
from tactogram.signal.signal import Signal

ORDER = 4
"""Butterworth order per edge and pass; forward and backward it falls at 48 dB per octave."""


def bandpass(signal: Signal, low: float, high: float) -> Signal:
    """Keep ``low`` to ``high``, without delay.

    A Butterworth filter of order `ORDER` per edge, run forward and backward. Its cut-offs are widened so that the
    *result* is at -3 dB at ``low`` and ``high`` (unchanged cut-offs would give -6 dB). The ends are mirrored; a signal
    may be of any length, but content slower than its duration depends on that assumption. ``low`` is at least 0 Hz (per
    mm over displacement), which keeps DC; ``high`` is above it and below half the rate.
    """
    sos = butterworth(signal.rate, low, high, passes=2)
    # Mirrored for three periods of the slower edge, or as far as the ends go.
    pad = min(len(signal) - 1, int(np.ceil(3 * signal.rate / (low or high))))
    x = signal.samples.astype(np.float64)
    y = scipy.signal.sosfiltfilt(sos, x, axis=1, padtype="even" if pad else None, padlen=pad)
    return signal.with_samples(y)


def butterworth(
    rate: float, low: float, high: float, *, order: int = ORDER, passes: int = 1
) -> NDArray[np.float64]:
    """Return the second-order sections of a Butterworth band-pass, float64, shape (section, 6).

    After ``passes`` runs over the same signal it is at -3 dB at ``low`` and ``high``, exactly. ``low`` 0 gives a
    low-pass, ``high`` infinite a high-pass.

    Notes
    -----
    One pass has the power gain 1 / (1 + W^2N) at W, the frequency in the analogue low-pass prototype; p passes reach
    1/2 at W = (2^(1/p) - 1)^(1/2N), so the prototype's band is widened by its inverse. The widening is done after
    pre-warping, tan(pi f / rate), about the same centre.
    """
    return _sections(rate, low, high, order, passes).copy()


@lru_cache(maxsize=256)
def _sections(rate: float, low: float, high: float, order: int, passes: int) -> NDArray[np.float64]:
    """Return the sections of `butterworth`; their design costs more than filtering a second of signal."""
    _check_band(rate, low, high)
    widened = (2 ** (1 / passes) - 1) ** (-0.5 / order)
    warped_low = np.tan(np.pi * low / rate)
    if np.isinf(high):
        edge = rate / np.pi * np.arctan(warped_low / widened)
        return np.asarray(scipy.signal.butter(order, edge, "highpass", fs=rate, output="sos"))
    warped_high = np.tan(np.pi * high / rate)
    if low == 0:
        edge = rate / np.pi * np.arctan(warped_high * widened)
        return np.asarray(scipy.signal.butter(order, edge, "lowpass", fs=rate, output="sos"))
    half_width = widened * (warped_high - warped_low) / 2
    centre = np.sqrt(half_width**2 + warped_low * warped_high)
    edges = rate / np.pi * np.arctan([warped_low * warped_high / (centre + half_width), centre + half_width])
    return np.asarray(scipy.signal.butter(order, edges, "bandpass", fs=rate, output="sos"))


def dft321(signal: Signal) -> Signal:
    """Combine three axes to one that has their energy at every frequency.

    Its spectrum has the root of the summed power of X, Y and Z as magnitude and the phase of X + Y + Z, over the whole
    signal in one transform. People hardly perceive the direction of a high-frequency vibration, so one axis with that
    energy feels like the three. Gravity remains as a constant.

    References
    ----------
    N. Landin, J. M. Romano, W. McMahan, K. J. Kuchenbecker, "Dimensional reduction of high-frequency accelerations for
    haptic rendering", EuroHaptics 2010, LNCS 6192, pp. 79-86: DFT321.
    """
    if len(signal.axes) != 3:
        raise ParameterError(f"dft321 needs three axes, got {len(signal.axes)} ({', '.join(signal.axes)})")
    spectra = scipy.fft.rfft(signal.samples.astype(np.float64), axis=1)
    magnitude = np.sqrt(np.sum(spectra.real**2 + spectra.imag**2, axis=0))
    phase = np.angle(spectra.sum(axis=0))
    combined = scipy.fft.irfft(magnitude * np.exp(1j * phase), n=len(signal))
    return signal.with_samples(combined, axes=("dft321",))


def principal_axis(signal: Signal) -> Signal:
    """Project the axes on the direction of greatest variance (first principal component), without its constant part.

    The direction is the whole signal's; of its two senses, the one whose largest component is positive.
    """
    x = signal.samples.astype(np.float64)
    x -= x.mean(axis=1, keepdims=True)
    direction = np.linalg.eigh(x @ x.T)[1][:, -1]
    direction *= np.sign(direction[np.abs(direction).argmax()])
    return signal.with_samples(direction @ x, axes=("pca",))


def differentiate(signal: Signal) -> Signal:
    """Return the velocity of a displacement, or the acceleration of a velocity, over time, of the same length.

    Exact up to half the rate, in the spectrum of the signal continued by point reflection at its ends (so that value
    and slope continue). It amplifies noise with frequency: band-limit first. At least two samples.
    """
    if signal.unit not in ("m", "m/s"):
        raise UnitError(f"only m and m/s can be differentiated, got {signal.unit}")
    if signal.domain != "time":
        raise ParameterError("a signal over displacement cannot be differentiated over time")
    n = len(signal)
    if n < 2:
        raise ParameterError.must("signal", "have at least two samples to be differentiated, got 1")
    x = signal.samples.astype(np.float64)
    slope = (x[:, -1:] - x[:, :1]) / (n - 1)
    x = x - x[:, :1] - slope * np.arange(n)
    x = np.concatenate([x, -x[:, -2:0:-1]], axis=1)
    spectrum = scipy.fft.rfft(x, axis=1) * 2j * np.pi * scipy.fft.rfftfreq(x.shape[1], 1 / signal.rate)
    y = scipy.fft.irfft(spectrum, n=x.shape[1], axis=1)[:, :n] + slope * signal.rate
    return signal.with_samples(y, unit=f"{signal.unit}/s" if signal.unit == "m" else "m/s^2")


def _check_band(rate: float, low: float, high: float) -> None:
    if not (0 <= low < high):
        raise ParameterError.must("band", f"be 0 <= low < high in Hz, got {low:g} {high:g}")
    top = high if np.isfinite(high) else low
    if top >= rate / 2:
        raise ParameterError.must(
            "band", f"end below half the rate ({rate / 2:g} Hz), got {low:g} {high:g}; lower its edges"
        )
    if low == 0 and np.isinf(high):
        raise ParameterError.must("band", "have an edge, got 0 inf")


def minimum_phase(log_magnitude: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the minimum-phase response, shape (time,), to a natural logarithm of magnitude from 0 to half the rate.

    By the real cepstrum; of n + 1 frequencies it has 2 n samples.

    References
    ----------
    A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, 3rd ed. (2010), Ch. 13.
    """
    cepstrum = np.fft.irfft(log_magnitude)
    half = len(cepstrum) // 2
    cepstrum[1:half] *= 2
    cepstrum[half + 1 :] = 0
    return np.asarray(np.fft.irfft(np.exp(np.fft.rfft(cepstrum))))
