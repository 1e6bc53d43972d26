"""Measures of how like two sets of signals are: blind to phase, in physical units, lower is better."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from tactogram.errors import ParameterError
from tactogram.signal import Signal

SEGMENT_S = 0.25
"""Length of the segments that a spectrum is averaged over, s: bins of 4 Hz."""


def log_spectral_distance(
    one: Sequence[Signal], other: Sequence[Signal], *, band: tuple[float, float] = (10.0, 1000.0)
) -> float:
    """Return the root mean square difference of two mean spectra in dB, over frequency and axes.

    Each set's power spectra (Welch 1967, Hann segments of `SEGMENT_S`) are averaged in dB. The level counts;
    phase, order and alignment do not. 0 dB is identical; two recordings of one texture are some dB apart,
    which is the floor to hold a generator against. Log-spectral distance: Gray and Markel 1976.

    Parameters
    ----------
    one, other : sequence of Signal
        All of one rate, unit and set of axes.
    band : (float, float), Hz
        What is compared; cut to what the rate holds.

    Returns
    -------
    float
        dB, >= 0.
    """
    kinds = {(s.rate, s.unit, s.axes) for s in (*one, *other)}
    if len(kinds) != 1:
        raise ParameterError(f"signals must have one rate, unit and set of axes, got {len(kinds)} kinds")
    difference = _mean_spectrum(one, band) - _mean_spectrum(other, band)
    return float(np.sqrt(np.mean(difference**2)))


def _mean_spectrum(signals: Sequence[Signal], band: tuple[float, float]) -> NDArray[np.float64]:
    """Return the mean power spectrum in dB, float64, shape (axis, frequency)."""
    length = round(SEGMENT_S * signals[0].rate)
    spectra = []
    for signal in signals:
        if len(signal) < length:
            raise ParameterError(f"signals must last at least {SEGMENT_S} s, got {signal.seconds:.3g} s")
        f, power = welch(signal.samples.astype(np.float64), signal.rate, nperseg=length)
        spectra.append(10 * np.log10(power[:, (f >= band[0]) & (f <= band[1])] + 1e-20))
    mean: NDArray[np.float64] = np.mean(spectra, axis=0)
    return mean
