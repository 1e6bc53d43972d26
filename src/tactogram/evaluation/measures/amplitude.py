"""Amplitude distribution distance of two sets of signals: blind to order and level."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.signal import sosfiltfilt

from tactogram.evaluation.measures.sets import check_alike, stacks
from tactogram.signal import Signal
from tactogram.signal.filters import butterworth

DRIFT_HZ = 10.0
"""What is slower is movement and drift and is left out: it would outweigh the vibration."""


def amplitude_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the 2-Wasserstein distance of two sets' amplitudes, in multiples of the rms; root mean square over axes.

    sqrt(integral over u of (F^-1(u) - G^-1(u))^2), where F and G are the distributions of the samples of a set,
    each signal's axis without what is slower than 10 Hz and divided by its own rms. Between distributions
    of rms 1 that is sqrt(2 (1 - r)), r the correlation of their quantiles: 0 for the same, sqrt(2) at most.

    The square weighs the tails: impacts and slips are rare samples of many times the rms, and they are what is
    felt. The distance of order 1 hardly sees them, and on a scale of dB it would see mostly samples near 0.
    Each signal is divided by its own rms, because `level_difference_db` sees the level already, and the mixing
    of levels would look like heavy tails. Blind to spectrum and order; hardly to phase: adding up many components
    of random phase makes any distribution normal.

    Parameters
    ----------
    one, other : sequence of Signal
        All of one rate, unit and set of axes, over time.

    Returns
    -------
    float
        Multiples of the rms, 0..sqrt(2) (1 where one set alone is silent).

    Raises
    ------
    ParameterError
        If the signals are not of one kind.

    References
    ----------
    C. Villani, Optimal Transport (2009), chap. 6; in one dimension it is the distance of the quantile functions.
    """
    check_alike(one, other)
    first, second = _unit_rms(one), _unit_rms(other)
    squares = [_squared_wasserstein_2(a, b) for a, b in zip(first, second, strict=True)]
    return float(np.sqrt(np.mean(squares)))


def without_drift(stack: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """Return ``stack`` (..., time) without its mean and what is slower than `DRIFT_HZ`, without delay."""
    x = stack - stack.mean(axis=-1, keepdims=True)
    if rate / 2 <= DRIFT_HZ:
        return np.asarray(x)
    sos = butterworth(rate, DRIFT_HZ, np.inf, order=2, passes=2)
    pad = min(x.shape[-1] - 1, int(np.ceil(3 * rate / DRIFT_HZ)))
    return np.asarray(sosfiltfilt(sos, x, axis=-1, padtype="even" if pad else None, padlen=pad))


def _unit_rms(signals: Sequence[Signal]) -> NDArray[np.float64]:
    """Return all samples of a set, sorted, float64, shape (axis, sample)."""
    pieces = []
    for stack in stacks(signals):
        x = without_drift(stack, signals[0].rate)
        rms = np.sqrt(np.mean(x**2, axis=-1, keepdims=True))
        relative = np.divide(x, rms, out=np.zeros_like(x), where=rms > 0)
        pieces.append(np.moveaxis(relative, 1, 0).reshape(x.shape[1], -1))
    return np.asarray(np.sort(np.concatenate(pieces, axis=1), axis=1))


def _squared_wasserstein_2(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Return the squared distance of two sorted samples, exactly, whatever their sizes."""
    n, m = len(first), len(second)
    if n == m:
        return float(np.mean((first - second) ** 2))
    # Quantile functions are steps; between two neighbours of all their edges both are constant. Edges are
    # counted in whole multiples of 1 / (n m), so that none is missed by rounding.
    edges = np.union1d(np.arange(n + 1, dtype=np.int64) * m, np.arange(m + 1, dtype=np.int64) * n)
    start = edges[:-1]
    steps = first[start // m] - second[start // n]
    return float(np.sum(np.diff(edges) * steps**2) / (n * m))
