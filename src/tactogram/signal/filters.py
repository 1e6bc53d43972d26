"""Filters on whole signals: band-pass, resampling, three axes to one, gravity. Unit and level are kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy import signal as dsp

from tactogram.errors import ParameterError, UnitError
from tactogram.signal.resampling import resample
from tactogram.signal.signal import Signal

__all__ = [
    "ORDER",
    "StreamBandpass",
    "bandpass",
    "butterworth",
    "dft321",
    "remove_gravity",
    "resample",
]

ORDER = 4
"""Butterworth order per edge and pass; forward and backward it falls at 48 dB per octave."""


def bandpass(signal: Signal, low: float, high: float) -> Signal:
    """Keep ``low`` to ``high``, without delay.

    A Butterworth filter of order `ORDER` per edge, run forward and backward. Its cut-offs are widened so that
    the *result* is at -3 dB at ``low`` and ``high`` (run twice unchanged it would be at -6 dB). The ends are
    mirrored; a signal may be of any length, but content slower than it lasts is only as good as that guess.

    Parameters
    ----------
    signal : Signal
    low : float
        Lower edge in Hz (per mm over displacement), >= 0; 0 keeps everything down to DC.
    high : float
        Upper edge, above ``low`` and below half the rate.

    Returns
    -------
    Signal
        Of the same length, rate and unit.

    Raises
    ------
    ParameterError
        If the band is empty or reaches half the rate.
    """
    sos = butterworth(signal.rate, low, high, passes=2)
    return signal.with_samples(_forward_backward(sos, signal, low or high))


class StreamBandpass:
    """A causal band-pass for a signal that arrives in blocks; how it is cut into blocks changes nothing.

    The Butterworth filter of `bandpass` run forward only, at -3 dB at ``low`` and ``high``. It delays, more
    towards the edges: `delay` says by how much. It starts as if the first sample had been there for ever, so
    that gravity makes no jump.

    Parameters
    ----------
    rate, low, high : float
        As in `bandpass`.
    order : int
        Per edge.

    Raises
    ------
    ParameterError
        If the band is empty or reaches half the rate.
    """

    def __init__(self, rate: float, low: float, high: float, *, order: int = ORDER) -> None:
        self.rate = float(rate)
        self._sos = butterworth(rate, low, high, order=order)
        self._state: NDArray[np.float64] | None = None

    def process(self, block: Signal) -> Signal:
        """Return the next block, filtered: as long as ``block``.

        Raises
        ------
        ParameterError
            If the block has another rate than the filter, or another number of axes than the block before.
        """
        if block.rate != self.rate:
            raise ParameterError(f"block must be at {self.rate:g} Hz, got {block.rate:g}")
        x = block.samples.astype(np.float64)
        if self._state is None:
            steady = dsp.sosfilt_zi(self._sos)
            self._state = steady[:, None, :] * x[None, :, :1]
        elif self._state.shape[1] != len(x):
            raise ParameterError(f"block must have {self._state.shape[1]} axes as before, got {len(x)}")
        y, self._state = dsp.sosfilt(self._sos, x, axis=1, zi=self._state)
        return block.with_samples(y)

    def reset(self) -> None:
        """Forget the past: the next block is a beginning."""
        self._state = None

    def delay(self, frequency: float) -> float:
        """Return the group delay in s at ``frequency`` in Hz."""
        w = 2 * np.pi * np.array([frequency * (1 - 1e-4), frequency * (1 + 1e-4)]) / self.rate
        _, response = dsp.sosfreqz(self._sos, worN=w)
        return float(-np.angle(response[1] / response[0]) / (w[1] - w[0]) / self.rate)


def butterworth(
    rate: float, low: float, high: float, *, order: int = ORDER, passes: int = 1
) -> NDArray[np.float64]:
    """Return the second-order sections of a Butterworth band-pass, float64, shape (section, 6).

    After ``passes`` runs over the same signal it is at -3 dB at ``low`` and ``high``, exactly.
    ``low`` 0 gives a low-pass, ``high`` infinite a high-pass.

    Notes
    -----
    One pass has the power gain 1 / (1 + W^2N) at W, the frequency in the analogue low-pass prototype;
    p passes reach 1/2 at W = (2^(1/p) - 1)^(1/2N), so the prototype's band is widened by its inverse.
    The widening is done after pre-warping, tan(pi f / rate), about the same centre.
    """
    _check_band(rate, low, high)
    widened = (2 ** (1 / passes) - 1) ** (-0.5 / order)
    warped_low = np.tan(np.pi * low / rate)
    if np.isinf(high):
        edge = rate / np.pi * np.arctan(warped_low / widened)
        return np.asarray(dsp.butter(order, edge, "highpass", fs=rate, output="sos"))
    warped_high = np.tan(np.pi * high / rate)
    if low == 0:
        edge = rate / np.pi * np.arctan(warped_high * widened)
        return np.asarray(dsp.butter(order, edge, "lowpass", fs=rate, output="sos"))
    half_width = widened * (warped_high - warped_low) / 2
    centre = np.sqrt(half_width**2 + warped_low * warped_high)
    edges = rate / np.pi * np.arctan([warped_low * warped_high / (centre + half_width), centre + half_width])
    return np.asarray(dsp.butter(order, edges, "bandpass", fs=rate, output="sos"))


def dft321(signal: Signal) -> Signal:
    """Combine three axes to one that has their energy at every frequency.

    Its spectrum has the root of the summed power of X, Y and Z as magnitude and the phase of X + Y + Z, over
    the whole signal in one transform. People hardly tell the direction of a high-frequency vibration, so one
    axis with that energy feels like the three. Gravity, if still there, comes through as a constant: remove
    it first.

    References
    ----------
    N. Landin, J. M. Romano, W. McMahan, K. J. Kuchenbecker, "Dimensional reduction of high-frequency
    accelerations for haptic rendering", EuroHaptics 2010, LNCS 6192, pp. 79-86: DFT321.

    Raises
    ------
    ParameterError
        If ``signal`` has not three axes.
    """
    if len(signal.axes) != 3:
        raise ParameterError(f"dft321 needs three axes, got {len(signal.axes)} ({', '.join(signal.axes)})")
    spectra = fft.rfft(signal.samples.astype(np.float64), axis=1)
    magnitude = np.sqrt(np.sum(spectra.real**2 + spectra.imag**2, axis=0))
    phase = np.angle(spectra.sum(axis=0))
    combined = fft.irfft(magnitude * np.exp(1j * phase), n=len(signal))
    return signal.with_samples(combined, axes=("dft321",))


def remove_gravity(signal: Signal, *, below: float = 1.0) -> Signal:
    """Remove gravity from an acceleration: everything slower than ``below``, on each axis.

    A constant is not enough, since a hand turns while it strokes. The high-pass is a Butterworth of order 2,
    forward and backward, at -3 dB at ``below``. A signal shorter than one period of ``below`` loses its mean.

    Parameters
    ----------
    signal : Signal
        In m/s^2, over time.
    below : float, Hz
        > 0 and below half the rate.

    Raises
    ------
    UnitError
        If ``signal`` is not an acceleration.
    ParameterError
        If ``signal`` is not over time, or ``below`` is out of range.
    """
    if signal.unit != "m/s^2":
        raise UnitError(f"gravity is removed from an acceleration in m/s^2, got {signal.unit}")
    if not below > 0:
        raise ParameterError(f"below must be > 0 Hz, got {below:g}")
    x = signal.samples.astype(np.float64)
    x -= x.mean(axis=1, keepdims=True)
    if signal.seconds * below < 1:
        return signal.with_samples(x)
    sos = butterworth(signal.rate, below, np.inf, order=2, passes=2)
    return signal.with_samples(_forward_backward(sos, signal.with_samples(x), below))


def _check_band(rate: float, low: float, high: float) -> None:
    if not (0 <= low < high):
        raise ParameterError(f"band must be 0 <= low < high in Hz, got {low:g} {high:g}")
    top = high if np.isfinite(high) else low
    if top >= rate / 2:
        raise ParameterError(
            f"band must end below half the rate ({rate / 2:g} Hz), got {low:g} {high:g}; lower its edges"
        )
    if low == 0 and np.isinf(high):
        raise ParameterError("band must have an edge, got 0 inf")


def _forward_backward(sos: NDArray[np.float64], signal: Signal, slowest: float) -> NDArray[np.float64]:
    """Filter both ways, the ends mirrored for three periods of the ``slowest`` edge or as far as they go."""
    pad = min(len(signal) - 1, int(np.ceil(3 * signal.rate / slowest)))
    x = signal.samples.astype(np.float64)
    return np.asarray(dsp.sosfiltfilt(sos, x, axis=1, padtype="even" if pad else None, padlen=pad))
