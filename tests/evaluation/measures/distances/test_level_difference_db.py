"""Level difference, and silence in what compares levels."""

import numpy as np
import pytest
from tests.evaluation.measures.distances.test_log_spectral_distance_db import texture
from tests.evaluation.measures.distances.test_weighted_log_spectral_distance_db import sine

from tactogram.evaluation.measures import (
    level_difference_db,
    log_spectral_distance,
    weighted_log_spectral_distance,
)
from tactogram.evaluation.measures.spectra import SILENT
from tactogram.signal import Signal


def test_the_level_of_sines_is_that_of_their_amplitudes():
    assert level_difference_db([sine(100, 3.0)], [sine(300, 1.0)]) == pytest.approx(
        20 * np.log10(3), abs=1e-3
    )
    # Sets are compared by their mean level in dB: 0 and 20 dB on one side are 10 dB.
    assert level_difference_db([sine(100, 1.0), sine(100, 10.0)], [sine(100, 1.0)]) == pytest.approx(
        10, abs=1e-3
    )


def test_gravity_and_drift_have_no_level():
    still = sine(100, 1.0)
    moved = still.with_samples(still.samples + 9.81 + np.sin(np.arange(len(still)) / 2000))
    assert level_difference_db([still], [moved]) < 0.02


def test_silence_is_finite():
    silent = Signal(np.zeros(500), 1000, "m/s^2")
    for measure in (log_spectral_distance, weighted_log_spectral_distance, level_difference_db):
        assert measure([silent], [silent]) == 0
        assert np.isfinite(measure([silent], [texture(0)]))
    assert level_difference_db([silent], [texture(0)]) > -10 * np.log10(SILENT) - 40
