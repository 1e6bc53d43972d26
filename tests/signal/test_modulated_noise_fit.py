"""Modulated noise fitted to recordings."""

import numpy as np
import pytest
from tests.signal.recorded_noise import MODEL, RATE, RECORDED, UNSEEN, pulsating

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.modulated_noise_fit import fit_modulated_noise, log_likelihood


def test_likelihood_prefers_the_fluctuation_it_was_fitted_to():
    other = fit_modulated_noise([pulsating(seed, frequency=25, depth=0.5) for seed in range(4)])
    assert log_likelihood(MODEL, UNSEEN[0]) > log_likelihood(other, UNSEEN[0]) + 0.5


def test_recordings_too_short_for_a_spectrum_are_left_out():
    short = RECORDED[0].cut(0, 10)
    assert fit_modulated_noise([*RECORDED, short]).covariance.tolist() == MODEL.covariance.tolist()


@pytest.mark.parametrize(
    ("signals", "options", "message"),
    [
        ([], {}, "at least one recording"),
        (Signal(np.ones(4000), 500.0, "V"), {}, "at least 800 Hz for modulated noise, got 500"),
        (Signal(np.ones(999), 4000.0, "1", domain="displacement"), {}, "over time, not over displacement"),
        (Signal(np.ones(100), RATE, "V"), {}, "at least 0.25 s, got 0.05"),
        (Signal(np.ones(600), RATE, "V"), {"lags": 0}, "lags must be >= 1, got 0"),
        (Signal(np.ones(600), RATE, "V"), {"lags": 40}, "at least 0.42 s, got 0.3"),
        (
            [Signal(np.ones(999), RATE, "V"), Signal(np.ones(999), RATE, "N")],
            {},
            "one rate, unit and set of axes",
        ),
    ],
)
def test_what_cannot_be_fitted_is_refused(signals, options, message):
    with pytest.raises(ParameterError, match=message):
        fit_modulated_noise(signals, **options)
