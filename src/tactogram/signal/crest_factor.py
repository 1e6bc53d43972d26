"""Phases that make a periodic signal of a given amplitude spectrum as flat as can be: a low crest factor.

The voltage of a drive is limited by the largest sample, what is felt follows the amplitudes of the lines. A signal of
low crest factor (peak / rms) therefore brings more of its spectrum to the skin than one of random phases.

References
----------
- Schroeder, M. R. (1970). Synthesis of low-peak-factor signals and binary sequences with low autocorrelation. IEEE
  Trans. Inf. Theory 16(1), 85-89. doi 10.1109/TIT.1970.1054411
- Van der Ouderaa, E., Schoukens, J. & Renneboog, J. (1988). Peak factor minimization using a time-frequency domain
  swapping algorithm. IEEE Trans. Instrum. Meas. 37(1), 145-147.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError

Start = Literal["random", "schroeder"]

SWAPS = 200
"""Clippings. More bring little: of 1,000 equal lines from random phases (3.50), 200 reach 1.51 and 1,000 1.44."""
CLIPPED = (0.75, 0.95)
"""Level of the first and the last clipping, as a share of the peak: Van der Ouderaa et al. raise it as it goes."""


def crest_factor(x: NDArray[np.floating]) -> float:
    """Return peak over rms of ``x``, shape (time,); sqrt(2) for a sinusoid.

    Raises
    ------
    ParameterError
        If ``x`` is 0 throughout: it has none.
    """
    rms = float(np.sqrt(np.mean(np.square(x, dtype=np.float64))))
    if rms == 0:
        raise ParameterError("a crest factor needs a sample that is not 0, got none")
    return float(np.abs(x).max()) / rms


def periodic_signal(
    amplitudes: NDArray[np.floating], phases: NDArray[np.floating], *, length: int
) -> NDArray[np.float64]:
    """Return one period of the sum of ``a_k cos(2 pi k n / length + phase_k)``, k from 1.

    It ends where it begins: repeated, it has no seam.

    Parameters
    ----------
    amplitudes : array, shape (bin,)
        Of the harmonics 1, 2, … of the period, in the unit of the signal.
    phases : array, shape (bin,), radians
    length : int, samples

    Returns
    -------
    float64 array, shape (time,)

    Raises
    ------
    ParameterError
        If there are more harmonics than lie below half the rate.
    """
    spectrum = _spectrum(amplitudes, length)
    spectrum[1 : len(amplitudes) + 1] *= np.exp(1j * np.asarray(phases, np.float64))
    return _time(spectrum, length)


def random_phases(count: int, *, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return phases drawn evenly from 0 to 2 pi, radians, shape (count,)."""
    return rng.uniform(0, 2 * np.pi, count)


def schroeder_phases(amplitudes: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return the phases of Schroeder 1970: a sweep that stays at each frequency in proportion to its power.

    Parameters
    ----------
    amplitudes : array, shape (bin,)

    Returns
    -------
    float64 array, shape (bin,), radians
    """
    power = np.square(amplitudes, dtype=np.float64)
    share = power / (power.sum() or 1.0)
    # The sum over l < k of (k - l) p_l is the running sum of the running sum.
    phases: NDArray[np.float64] = -2 * np.pi * np.concatenate(([0.0], np.cumsum(np.cumsum(share))[:-1]))
    return phases


def low_crest_phases(
    amplitudes: NDArray[np.floating],
    *,
    length: int,
    rng: np.random.Generator,
    start: Start = "random",
    swaps: int = SWAPS,
) -> NDArray[np.float64]:
    """Return phases of a low crest factor: clip, keep the phases of what comes out, put the amplitudes back, repeat.

    Van der Ouderaa et al. 1988. The best of all turns is returned, the start among them.

    Parameters
    ----------
    amplitudes : array, shape (bin,)
        Of the harmonics 1, 2, … of the period; kept exactly, whatever the phases.
    length : int, samples
        Of the period.
    rng : numpy.random.Generator
        Of the phases to begin with.
    start : {"random", "schroeder"}
        ``schroeder`` ends lower, but is one sweep per period, which is felt as one; ``random`` stays even
        noise.
    swaps : int
        Clippings.

    Returns
    -------
    float64 array, shape (bin,), radians
    """
    count = len(amplitudes)
    phases = random_phases(count, rng=rng) if start == "random" else schroeder_phases(amplitudes)
    level = _spectrum(amplitudes, length)
    if not level.any():
        return phases
    inside = slice(1, count + 1)
    best, least = phases, np.inf
    for clipped in np.linspace(*CLIPPED, swaps + 1):
        spectrum = level.copy()
        spectrum[inside] *= np.exp(1j * phases)
        x = _time(spectrum, length)
        peak = np.abs(x).max()
        if peak < least:
            best, least = phases, peak
        limit = clipped * peak
        phases = np.angle(np.fft.rfft(np.clip(x, -limit, limit))[inside])
    return best


def _spectrum(amplitudes: NDArray[np.floating], length: int) -> NDArray[np.complex128]:
    """Return what ``rfft`` gives of one period of cosines of ``amplitudes``."""
    if 2 * len(amplitudes) >= length:
        raise ParameterError(
            f"harmonics must lie below half the rate: at most {(length - 1) // 2} of {length} samples, "
            f"got {len(amplitudes)}"
        )
    spectrum = np.zeros(length // 2 + 1, np.complex128)
    spectrum[1 : len(amplitudes) + 1] = np.asarray(amplitudes, np.float64) * (length / 2)
    return spectrum


def _time(spectrum: NDArray[np.complex128], length: int) -> NDArray[np.float64]:
    x: NDArray[np.float64] = np.fft.irfft(spectrum, length)
    return x
