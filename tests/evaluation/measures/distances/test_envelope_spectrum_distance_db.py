"""Envelope spectrum distance, and what it shares with the modulation spectrum's."""

import numpy as np
import pytest
from tests.evaluation.measures.test_spectra import modulated

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import envelope_spectrum_distance, modulation_spectrum_distance
from tactogram.evaluation.measures.spectra import MODULATION_FLOOR_DB
from tactogram.signal import Signal


def test_twice_the_depth_is_6_db_in_the_band_where_it_is():
    # All other half octaves are at the floor on both sides; 2 to 100 Hz has 11 of them.
    one, other = modulated(0.2, 20.0), modulated(0.4, 20.0)
    expected = 20 * np.log10(2) / np.sqrt(11)
    assert envelope_spectrum_distance([one], [other]) == pytest.approx(expected, rel=0.05)


def test_even_against_modulated_is_as_far_as_the_floor():
    depth = 0.5
    far = 10 * np.log10(depth**2 / 2) - MODULATION_FLOOR_DB
    assert envelope_spectrum_distance([modulated(0.0)], [modulated(depth, 20.0)]) == pytest.approx(
        far / np.sqrt(11), rel=0.05
    )


@pytest.mark.parametrize("measure", [envelope_spectrum_distance, modulation_spectrum_distance])
def test_level_does_not_count(measure, texture):
    one, other = texture(0, burst_hz=8), texture(1)
    apart = measure([one], [other])
    for gain in (30.0, 0.5):
        louder = other.with_samples(gain * other.samples)
        assert measure([one], [louder]) == pytest.approx(apart, rel=0.05)


@pytest.mark.parametrize("measure", [envelope_spectrum_distance, modulation_spectrum_distance])
def test_too_short_or_too_slow_is_refused(measure):
    with pytest.raises(ParameterError, match="at least 0.5 s, got 0.4 s"):
        measure([modulated(0.1, seconds=0.4)], [modulated(0.1, seconds=4)])
    slow = Signal(np.ones(100), 40, "1")
    with pytest.raises(ParameterError, match="rate must be above 40 Hz"):
        measure([slow], [slow])


@pytest.mark.parametrize("measure", [envelope_spectrum_distance, modulation_spectrum_distance])
@pytest.mark.parametrize("rate", [100.0, 330.0, 1000.0, 8000.0])
def test_every_rate_that_contains_vibration_is_accepted(measure, rate):
    random = np.random.default_rng(0)
    a, b = (Signal(random.standard_normal((3, round(2 * rate))), rate, "m/s^2") for _ in range(2))
    assert 0 < measure([a], [b]) < 10


@pytest.mark.parametrize("measure", [envelope_spectrum_distance, modulation_spectrum_distance])
def test_silence_is_finite(measure, texture):
    silent = Signal(np.zeros((3, 4000)), 1000, "m/s^2", ("x", "y", "z"))
    assert measure([silent], [silent]) == 0
    assert np.isfinite(measure([silent], [texture(0)]))
