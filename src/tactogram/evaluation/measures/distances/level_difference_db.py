"""Level difference: blind to everything else."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactogram.evaluation.measures.measure import Measure, check_alike
from tactogram.evaluation.measures.spectra import BAND_HZ, SEGMENT_S, SILENT, check_band, power_spectra
from tactogram.signal import Signal


def level_difference_db(
    one: Sequence[Signal], other: Sequence[Signal], *, band: tuple[float, float] = BAND_HZ
) -> float:
    """Return by how many dB the mean levels of two sets differ, ignoring the sign.

    The level of a signal is 10 log10 of its mean square within ``band``, Hz, summed over axes; silence counts
    as `SILENT`.
    """
    check_alike(one, other, shortest_s=SEGMENT_S)
    first, second = (_level_db(members, band) for members in (one, other))
    return abs(first - second)


def _level_db(signals: Sequence[Signal], band: tuple[float, float]) -> float:
    spectra = power_spectra(signals)
    total = spectra.power[..., check_band(spectra.frequency, band)].sum(axis=(1, 2)) * spectra.frequency[1]
    return float(np.mean(10 * np.log10(np.maximum(total, SILENT))))


MEASURE = Measure(
    "level_difference_db",
    level_difference_db,
    "dB",
    title="level difference",
    source="this project",
    rank=30,
)
