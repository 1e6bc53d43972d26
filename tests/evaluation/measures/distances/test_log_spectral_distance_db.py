"""Log spectral distance."""

import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import (
    log_spectral_distance,
    weighted_log_spectral_distance,
)
from tactogram.signal import Signal


def texture(seed, pole=0.9, gain=1.0, seconds=4):
    noise = np.random.default_rng(seed).standard_normal(int(1000 * seconds))
    return Signal(gain * lfilter([1], [1, -pole], noise), 1000, "m/s^2")


def test_identical_sets_have_distance_0():
    assert log_spectral_distance([texture(0)], [texture(0)]) == 0


def test_a_level_difference_of_6_db_is_6_db():
    assert log_spectral_distance([texture(0, gain=2)], [texture(0)]) == pytest.approx(
        20 * np.log10(2), abs=1e-4
    )


def test_phase_and_shift_do_not_count_but_another_texture_does():
    floor = log_spectral_distance([texture(0)], [texture(1)])
    late = texture(0).cut(2)
    assert log_spectral_distance([late], [texture(0)]) < 0.2
    assert floor < 2
    assert log_spectral_distance([texture(0)], [texture(1, pole=-0.5)]) > 5 * floor


def test_signals_of_different_kinds_are_refused():
    with pytest.raises(ParameterError, match="got 2 kinds"):
        log_spectral_distance([texture(0)], [Signal(np.ones(500), 500, "m/s^2")])
    with pytest.raises(ParameterError, match=r"at least 0.25 s, got 0.1 s"):
        log_spectral_distance([texture(0, seconds=0.1)], [texture(0)])
    with pytest.raises(ParameterError, match="band must hold a frequency below 500 Hz, got 600 800"):
        log_spectral_distance([texture(0)], [texture(0)], band=(600, 800))


def test_the_distance_is_the_difference_of_two_filters():
    # White noise and the same through 1 - 0.5/z: the distance is that of the filter's gain from 0 dB.
    noise = [np.random.default_rng(k).standard_normal(4000) for k in range(6)]
    one = [Signal(x, 1000, "1") for x in noise]
    other = [Signal(lfilter([1, -0.5], [1], x), 1000, "1") for x in noise]
    f = np.arange(12, 501, 4)  # segments of 0.25 s: 4 Hz
    gain_db = 20 * np.log10(np.abs(1 - 0.5 * np.exp(-2j * np.pi * f / 1000)))
    assert log_spectral_distance(one, other) == pytest.approx(np.sqrt(np.mean(gain_db**2)), abs=0.05)


def test_length_does_not_bias_the_distance():
    # The mean logarithm of the spectrum of one segment is 2.5 dB below that of many.
    random = np.random.default_rng(0)
    short = [Signal(random.standard_normal(250), 1000, "1") for _ in range(1500)]
    long = [Signal(random.standard_normal(4000), 1000, "1") for _ in range(60)]
    assert log_spectral_distance(short, long) < 0.5
    assert weighted_log_spectral_distance(short, long) < 0.5


def test_a_filtered_out_band_does_not_count():
    t = texture(0).samples
    a = Signal(t + 1e-7 * texture(1, pole=-0.9).samples, 1000, "1")
    low = np.fft.irfft(np.fft.rfft(t) * (np.fft.rfftfreq(4000, 1e-3) < 200), n=4000)
    quiet = [
        Signal(low + g * np.random.default_rng(2).standard_normal(4000), 1000, "1") for g in (1e-6, 1e-5)
    ]
    assert log_spectral_distance(quiet[:1], quiet[1:]) < 0.1  # 20 dB apart where nothing is
    assert log_spectral_distance([a], [Signal(t, 1000, "1")]) < 0.1
