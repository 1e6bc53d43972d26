"""Envelopes of sets of signals, and how they fluctuate.

Two textures of one spectrum feel different when one is even and the other comes in bursts, ridges or slips. A
power spectrum cannot show that; the spectrum of an envelope can.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.signal import welch

from tactogram.evaluation.measures.bands import band_edges, band_sums
from tactogram.signal import Signal

MODULATION_HZ = (2.0, 100.0)
"""Slower is how the hand moves, faster is felt as frequency rather than fluctuation."""

WINDOW_S = 1.0
"""Length of the Hann windows that an envelope's spectrum is averaged over, s. Shorter signals shorten the window to
their length, and the slowest modulation included is then 2 / length."""

SHORTEST_S = 0.5
"""Minimum length of signals, s."""

MODULATION_FLOOR_DB = -40.0
"""Less modulation in a band counts as this: a depth of 1.4 %, which nobody feels."""


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
