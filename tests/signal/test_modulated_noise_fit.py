"""Modulated noise fitted to recordings."""

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.signal import Signal
from tactogram.signal.modulated_noise_fit import fit_modulated_noise, log_likelihood

RATE = 2000.0


def pulsating(seed, *, frequency=5.0, depth=0.9, level=0.3, seconds=4.0, pole=0.9, axes=1):
    """Return noise of an autoregressive spectrum whose strength follows a sine of random phase."""
    random = np.random.default_rng(seed)
    count = round(seconds * RATE)
    x = lfilter([1], [1, -1.2, pole**2], random.standard_normal((axes, count + 200)))[:, 200:]
    t = np.arange(count) / RATE
    x *= 1 + depth * np.sin(2 * np.pi * (frequency * t + random.random()))
    return Signal(level * x / x.std(), RATE, "m/s^2", ("x", "y", "z")[:axes])


RECORDED = [pulsating(seed) for seed in range(4)]


UNSEEN = [pulsating(seed) for seed in range(10, 14)]


MODEL = fit_modulated_noise(RECORDED)


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
