"""Log-spectral distance: blind to phase."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactogram.evaluation.measures.measure import Measure, check_alike
from tactogram.evaluation.measures.spectra import (
    BAND_HZ,
    SEGMENT_S,
    check_band,
    mean_spectrum_db,
    power_spectra,
)
from tactogram.signal import Signal

DYNAMIC_RANGE_DB = 80.0
"""Bins farther than this below the strongest bin of both sets are raised to this limit: what a filter or a converter
leaves there says nothing about a texture."""


def log_spectral_distance(
    one: Sequence[Signal], other: Sequence[Signal], *, band: tuple[float, float] = BAND_HZ
) -> float:
    """Return the root mean square difference between two mean spectra in dB, over frequency and axes.

    sqrt(mean over f and axes of (L1(f) - L2(f))^2), where L is the mean over a set's signals of
    10 log10 of their power spectra (Welch 1967, Hann segments of `SEGMENT_S`, half overlapping). Sensitive to level;
    blind to phase, order and alignment. 0 dB means identical; two recordings of one texture are a few dB
    apart, which is the floor for a generator.

    The logarithm of a spectrum from K independent segments is too low by 10/ln 10 (ln K - digamma(K)) dB on average
    (2.5 dB for one). This bias is corrected, so that signals of different lengths can be compared.

    Signals last at least `SEGMENT_S`; frequencies in ``band``, Hz, are compared.

    References
    ----------
    A. H. Gray, J. D. Markel, "Distance measures for speech processing", IEEE Trans. ASSP 24 (1976) 380-391.
    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73, for the estimate.
    """
    check_alike(one, other, shortest_s=SEGMENT_S)
    spectra = [power_spectra(members) for members in (one, other)]
    inside = check_band(spectra[0].frequency, band)
    floor = 10 ** (-DYNAMIC_RANGE_DB / 10) * max(s.power[..., inside].max() for s in spectra)
    if floor == 0:
        return 0.0
    first, second = (
        mean_spectrum_db(np.maximum(s.power[..., inside], floor), s.independent) for s in spectra
    )
    return float(np.sqrt(np.mean((first - second) ** 2)))


MEASURE = Measure(
    "log_spectral_distance_db",
    log_spectral_distance,
    "dB",
    title="log-spectral distance",
    source="Gray & Markel 1976",
    rank=10,
)
