import numpy as np
import pytest
from scipy.signal import hilbert

from tactogram.errors import ParameterError
from tactogram.evaluation.measures import envelope_spectrum_distance, modulation_spectrum_distance
from tactogram.evaluation.measures.spectra import MODULATION_FLOOR_DB, band_edges, envelopes, modulation_power
from tactogram.signal import Signal


def modulated(depth, modulation=18.0, carrier=200.0, rate=2000.0, seconds=4.0):
    t = np.arange(round(seconds * rate)) / rate
    x = np.sin(2 * np.pi * carrier * t) * (1 + depth * np.sin(2 * np.pi * modulation * t))
    return Signal(x, rate, "m/s^2")


def test_the_envelope_of_a_sine_is_its_amplitude():
    x = modulated(0.0).samples.astype(np.float64) * 3
    envelope, rate = envelopes(x, 2000.0, 20, 1000, np.ones_like)
    assert rate >= 2 * 980
    ends = round(0.05 * rate)  # a mirrored sine turns round there
    np.testing.assert_allclose(envelope[0, ends:-ends], 3.0, atol=0.05)


def test_it_is_the_analytic_signals_magnitude():
    x = modulated(0.6).samples.astype(np.float64)
    envelope, rate = envelopes(x, 2000.0, 100, 300, np.ones_like)
    time = np.arange(envelope.shape[1]) / rate
    reference = np.interp(time, np.arange(x.shape[1]) / 2000.0, np.abs(hilbert(x[0])))
    middle = slice(len(time) // 20, -len(time) // 20)  # the mirrored ends are not what hilbert makes of them
    np.testing.assert_allclose(envelope[0, middle], reference[middle], atol=0.02)


@pytest.mark.parametrize("depth", [0.05, 0.3, 0.9])
@pytest.mark.parametrize("modulation", [3.0, 18.0, 50.0])
def test_a_modulation_of_depth_m_has_half_its_square_as_power(depth, modulation):
    x = modulated(depth, modulation).samples.astype(np.float64)
    envelope, rate = envelopes(x, 2000.0, 20, 1000, np.ones_like)
    edges = band_edges(1, 100, per_octave=1)
    power = modulation_power(envelope, rate, 2.0, edges)[0]
    band = np.searchsorted(edges, modulation) - 1
    assert power.sum() == pytest.approx(depth**2 / 2, rel=0.02)
    assert power.argmax() == band


def test_a_silent_envelope_has_no_modulation():
    assert (modulation_power(np.zeros((2, 500)), 250.0, 1.0, band_edges(1, 100, per_octave=1)) == 0).all()


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


def test_an_absent_carrier_band_does_not_count():
    one = modulated(0.4, carrier=100.0)
    random = np.random.default_rng(0)
    hiss = one.with_samples(one.samples + 1e-5 * random.standard_normal(one.samples.shape))
    assert modulation_spectrum_distance([one], [hiss]) < 0.1


def test_bursts_in_one_band_are_detected(texture, even):
    # Two bands fluctuate in opposite phase: the whole envelope is nearly even, each band's is not.
    t = np.arange(8000) / 2000
    low, high = np.sin(2 * np.pi * 60 * t), np.sin(2 * np.pi * 400 * t)
    swing = 0.5 * np.sin(2 * np.pi * 6 * t)
    still = Signal(low + high, 2000, "1")
    swinging = Signal(low * (1 + swing) + high * (1 - swing), 2000, "1")
    assert modulation_spectrum_distance([still], [swinging]) > 5


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
