"""Amplitude distribution distance: blind to order and level."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactogram.evaluation.measures.measure import Measure, check_alike, once_per_set, stacks
from tactogram.evaluation.measures.spectra import without_drift
from tactogram.signal import Signal


def amplitude_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the 2-Wasserstein distance between two sets' amplitudes, root mean square over axes.

    sqrt(integral over u of (F^-1(u) - G^-1(u))^2), where F and G are the distributions of the samples of a set,
    each signal's axis high-passed at 10 Hz and divided by its own rms. Between distributions
    of rms 1 that is sqrt(2 (1 - r)), r the correlation of their quantiles: 0 for the same, sqrt(2) at most.

    The square emphasises the tails: impacts and slips are rare samples of many times the rms, and they are what is
    felt. The distance of order 1 hardly registers them, and a scale in dB would be dominated by samples near 0.
    Each signal is divided by its own rms, because `level_difference_db` covers the level, and mixed
    levels would look like heavy tails. Blind to spectrum and order. Phase matters little: the sum of many components
    of random phase is always normally distributed.

    The result is in multiples of the rms, 0..sqrt(2) (1 if only one set is silent).

    References
    ----------
    C. Villani, Optimal Transport (2009), chap. 6; in one dimension it is the distance of the quantile functions.
    """
    check_alike(one, other)
    first, second = _unit_rms(one), _unit_rms(other)
    squares = [_squared_wasserstein_2(a, b) for a, b in zip(first, second, strict=True)]
    return float(np.sqrt(np.mean(squares)))


@once_per_set
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
    """Return the exact squared distance between two sorted samples of any sizes."""
    n, m = len(first), len(second)
    if n == m:
        return float(np.mean((first - second) ** 2))
    # Quantile functions are steps; between neighbouring edges both are constant. Edges are
    # counted in whole multiples of 1 / (n m), so that rounding loses none.
    edges = np.union1d(np.arange(n + 1, dtype=np.int64) * m, np.arange(m + 1, dtype=np.int64) * n)
    start = edges[:-1]
    steps = first[start // m] - second[start // n]
    return float(np.sum(np.diff(edges) * steps**2) / (n * m))


MEASURE = Measure(
    "amplitude_distance",
    amplitude_distance,
    "rms",
    title="amplitude distribution distance",
    source="2-Wasserstein; Villani 2009",
    rank=60,
)
