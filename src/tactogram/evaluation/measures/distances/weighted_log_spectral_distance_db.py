"""Perceptually weighted log-spectral distance: blind to phase."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tactogram.evaluation.measures.measure import Measure, check_alike
from tactogram.evaluation.measures.spectra import (
    SEGMENT_S,
    band_sums,
    felt_edges,
    felt_floor_db,
    felt_weight,
    mean_spectrum_db,
    power_spectra,
)
from tactogram.signal import Signal

HANN_BINS = 1.5
"""Bandwidth of the Hann window in bins."""


def weighted_log_spectral_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the root mean square difference between two mean spectra in dB, weighted by what is felt.

    sqrt(sum w D^2 / sum w) over third octaves of `FELT_HZ` and axes. L1, L2 are the sets' mean levels in a
    band relative to the detection threshold, raised to the floor of what is felt at all; D = L1 - L2 and
    w = max(L1, L2) - floor. A level error of x dB gives x dB; a band that is felt in neither set does not count.

    The floor is 50 dB below the strongest band, but at least 20 dB below the threshold, since some people are that
    much more sensitive. For units without a threshold (sound, counts, V, N) only the shape of a
    threshold curve is used (see `bands.FELT_LIKE`) and the floor is only relative: level errors count, the
    distance from the threshold does not.

    The rate is above 40 Hz, and signals last at least `SEGMENT_S`.

    References
    ----------
    The distance: Gray and Markel 1976, as in `log_spectral_distance`. The threshold and its limits:
    `tactogram.signal.perception` (Verrillo 1963). Bands, floor and weight are this project's choice.
    """
    kind = check_alike(one, other, shortest_s=SEGMENT_S)
    edges = felt_edges(kind.rate)
    first, second = _felt_levels(one, edges), _felt_levels(other, edges)
    floor = felt_floor_db(kind.unit, first, second)
    first, second = np.maximum(first, floor), np.maximum(second, floor)
    weight = np.maximum(first, second) - floor
    if not weight.any():
        return 0.0
    return float(np.sqrt(np.sum(weight * (first - second) ** 2) / np.sum(weight)))


def _felt_levels(signals: Sequence[Signal], edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean level per band in dB re threshold (0 dB is a sine at threshold), shape (axis, band)."""
    spectra = power_spectra(signals)
    weight = np.zeros(len(spectra.frequency))
    weight[1:] = felt_weight(spectra.frequency[1:], signals[0].unit)
    spacing = spectra.frequency[1]
    band_power = 2 * spacing * band_sums(spectra.power * weight, spectra.frequency, edges)
    estimates = np.maximum(1.0, np.diff(edges) / (HANN_BINS * spacing))
    return mean_spectrum_db(band_power, spectra.independent[:, None] * estimates)


MEASURE = Measure(
    "weighted_log_spectral_distance_db",
    weighted_log_spectral_distance,
    "dB",
    title="perceptually weighted log-spectral distance",
    source="Gray & Markel 1976; threshold: Verrillo 1963",
    rank=20,
)
