"""Vibrotactile perception: detection threshold over frequency, sensation level, weighting.

Sources
-------
- Below 250 Hz the threshold follows R. T. Verrillo, "Effect of contactor area on the vibrotactile threshold", J.
  Acoust. Soc. Am. 35 (1963) 1962-1966, for contactors of 2.9 cm^2 and more: flat to 40 Hz, then falling by 12 dB per
  octave to a minimum near 250 Hz. These facts were checked in the abstract only.
- The minimum itself, 0.1 µm peak, is general knowledge of the field; it was *not* checked in a source.
- Above 250 Hz it rises as the closed form in `spqi_threshold_db`, checked in two public codebases; how well that fits
  people was *not* checked.
- A grasped cylinder has its minimum at 150-200 Hz, for some below 0.01 µm (A. J. Brisben, S. S. Hsiao, K. O. Johnson,
  J. Neurophysiol. 81 (1999) 1548-1558), and people differ: absolute levels are accurate to some 10 dB, comparisons of
  two signals are better.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from tactogram.errors import ParameterError, UnitError
from tactogram.signal.signal import Signal

MINIMUM_M = 1e-7
"""Threshold at the most sensitive frequency, peak amplitude of a sine. Not checked in a source."""
MOST_SENSITIVE_HZ = 250.0
FLAT_BELOW_HZ = 40.0
SLOPE_DB_PER_OCTAVE = -12.0

FELT_HZ = (20.0, 1000.0)
"""Band of vibration: slower movement, and the drift of an acceleration, would dominate; faster is hardly felt."""


def detection_threshold(frequency: ArrayLike, unit: str = "m") -> NDArray[np.float64]:
    """Return the peak amplitude of the weakest perceptible sine.

    Parameters
    ----------
    frequency : float array, any shape, Hz
        > 0.
    unit : {"m", "m/s", "m/s^2"}
        Displacement, or its velocity or acceleration: times 2 pi f once or twice.

    Returns
    -------
    float64 array, the shape of ``frequency``
        In ``unit``. The module docstring states the accuracy.
    """
    f = np.asarray(frequency, dtype=np.float64)
    if not (np.all(f > 0) and np.all(np.isfinite(f))):
        raise ParameterError.must("frequency", "be > 0 Hz and finite")
    powers = {"m": 0, "m/s": 1, "m/s^2": 2}
    if unit not in powers:
        raise UnitError(f"a threshold is known in {', '.join(powers)}, got {unit}")
    octaves = np.log2(np.clip(f, FLAT_BELOW_HZ, MOST_SENSITIVE_HZ) / MOST_SENSITIVE_HZ)
    above = spqi_threshold_db(np.maximum(f, MOST_SENSITIVE_HZ)) - spqi_threshold_db(MOST_SENSITIVE_HZ)
    level_db = SLOPE_DB_PER_OCTAVE * octaves + above
    return np.asarray(MINIMUM_M * 10 ** (level_db / 20) * (2 * np.pi * f) ** powers[unit])


def spqi_threshold_db(frequency: ArrayLike) -> NDArray[np.float64]:
    """Return the threshold curve of the vibrotactile codec measures SPQI and ST-SIM, dB re the signal's scale.

    T(f) = 62 (log10(f/550 + 6/11) / log10(6/11))^2 - 77, at most 0: -77 dB at 250 Hz, 0 dB from 781 Hz on. Constants as
    in the public package vibromaf. The scale is that of the evaluated signal, not metres. ``frequency`` (Hz, >= 0) has
    any shape, which the result (float64) keeps.
    """
    f = np.asarray(frequency, dtype=np.float64)
    if not np.all(f >= 0):
        raise ParameterError.must("frequency", "be >= 0 Hz")
    curve = 62 / np.log10(6 / 11) ** 2 * np.log10(f / 550 + 6 / 11) ** 2 - 77
    return np.asarray(np.minimum(curve, 0.0))


def weighted(signal: Signal, *, band: tuple[float, float] = FELT_HZ) -> Signal:
    """Return ``signal`` in multiples of the threshold at each frequency.

    Zero phase, over the whole signal, mirrored at its ends; 0 outside of ``band`` (Hz). The result has unit 1: a sine
    of peak 1 is at threshold, whatever its frequency. ``signal`` is over time, in m, m/s or m/s^2.
    """
    _check(signal, band)
    n = len(signal)
    x = signal.samples.astype(np.float64)
    x -= x.mean(axis=1, keepdims=True)
    spectrum = fft.rfft(np.concatenate([x, x[:, ::-1]], axis=1), axis=1)
    frequency = fft.rfftfreq(2 * n, 1 / signal.rate)
    weight = _weight(frequency, signal.unit, band)
    return signal.with_samples(fft.irfft(spectrum * weight, n=2 * n, axis=1)[:, :n], unit="1")


def sensation_level_db(signal: Signal, *, band: tuple[float, float] = FELT_HZ) -> float:
    """Return the level of a vibration above its detection threshold, dB.

    The mean power of all frequencies and axes, each relative to its threshold, added up (Welch's estimate over one
    second, Hann): 0 dB is a sine at threshold, -inf is silence. One channel of touch adds power within its band
    (general knowledge, not checked in a source); between channels this is a simplification.
    """
    _check(signal, band)
    x = signal.samples.astype(np.float64)
    length = min(len(signal), int(np.ceil(signal.rate)))
    frequency, power = scipy.signal.welch(
        x, signal.rate, nperseg=length, scaling="density", detrend="constant", axis=1
    )
    weight = _weight(frequency, signal.unit, band)
    ratio = 2 * float(np.sum(power * weight**2)) * signal.rate / length
    return float(10 * np.log10(ratio)) if ratio > 0 else -np.inf


def _check(signal: Signal, band: tuple[float, float]) -> None:
    if signal.domain != "time":
        raise ParameterError("a signal over displacement is felt only at a speed: it must be over time")
    if not 0 < band[0] < band[1]:
        raise ParameterError.must("band", f"be 0 < low < high in Hz, got {band[0]:g} {band[1]:g}")


def _weight(frequency: NDArray[np.float64], unit: str, band: tuple[float, float]) -> NDArray[np.float64]:
    kept = (frequency >= band[0]) & (frequency <= band[1])
    weight = np.zeros(len(frequency))
    weight[kept] = 1 / detection_threshold(frequency[kept], unit)
    return weight
