import numpy as np
import pytest
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import log_spectral_distance
from tactogram.signal import Signal


def texture(seed, pole=0.9, gain=1.0, seconds=4):
    noise = np.random.default_rng(seed).standard_normal(int(1000 * seconds))
    return Signal(gain * lfilter([1], [1, -pole], noise), 1000, "m/s^2")


def test_the_same_is_nothing_apart():
    assert log_spectral_distance([texture(0)], [texture(0)]) == 0


def test_a_level_of_6_db_is_6_db():
    assert log_spectral_distance([texture(0, gain=2)], [texture(0)]) == pytest.approx(
        20 * np.log10(2), abs=1e-4
    )


def test_phase_and_shift_do_not_count_but_another_texture_does():
    floor = log_spectral_distance([texture(0)], [texture(1)])
    late = texture(0).cut(2)
    assert log_spectral_distance([late], [texture(0)]) < 0.2
    assert floor < 2
    assert log_spectral_distance([texture(0)], [texture(1, pole=-0.5)]) > 5 * floor


def test_kinds_are_not_mixed():
    with pytest.raises(ParameterError, match="got 2 kinds"):
        log_spectral_distance([texture(0)], [Signal(np.ones(500), 500, "m/s^2")])
    with pytest.raises(ParameterError, match=r"at least 0.25 s, got 0.1 s"):
        log_spectral_distance([texture(0, seconds=0.1)], [texture(0)])
