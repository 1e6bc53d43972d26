"""Bands, thresholds, envelopes and their modulation."""

import numpy as np
import pytest
from scipy.signal import hilbert

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.spectra import (
    band_edges,
    band_sums,
    envelopes,
    felt_edges,
    felt_floor_db,
    felt_weight,
    modulation_power,
)
from tactogram.signal import Signal
from tactogram.signal.perception import detection_threshold


def test_edges_are_evenly_spaced_octaves():
    np.testing.assert_allclose(band_edges(20, 160, per_octave=1), [20, 40, 80, 160])
    assert len(felt_edges(8000)) == 18  # third octaves of 20 to 1000 Hz
    assert felt_edges(330)[-1] == 165


def test_a_rate_without_vibration_is_refused():
    with pytest.raises(ParameterError, match="rate must be above 40 Hz"):
        felt_edges(40)
    with pytest.raises(ParameterError, match="low < high"):
        band_edges(30, 20, per_octave=1)


def test_nothing_is_lost_or_counted_twice_between_bands():
    frequency = np.arange(0, 501, 4.0)
    values = np.random.default_rng(0).random((2, len(frequency)))
    edges = band_edges(3.0, 490.0, per_octave=7)  # the lowest are narrower than the spacing
    narrow = band_sums(values, frequency, edges)
    whole = band_sums(values, frequency, edges[[0, -1]])
    np.testing.assert_allclose(narrow.sum(axis=1), whole[:, 0])
    assert (narrow > 0).all()


def test_a_flat_density_gives_each_band_its_width():
    frequency = np.arange(0, 501, 4.0)
    edges = band_edges(20, 400, per_octave=3)
    sums = band_sums(np.ones(len(frequency)), frequency, edges) * 4.0
    np.testing.assert_allclose(sums, np.diff(edges))


def test_a_unit_without_threshold_uses_only_the_shape():
    frequency = np.array([20.0, 100.0, 250.0, 700.0])
    for unit, like in (("1", "m/s^2"), ("V", "m/s^2"), ("N", "m")):
        shape = felt_weight(frequency, unit)
        assert shape.max() == 1
        absolute = detection_threshold(frequency, like) ** -2.0
        np.testing.assert_allclose(shape, absolute / absolute.max())


def test_the_floor_is_near_the_threshold_or_the_range_below_the_strongest():
    assert felt_floor_db("m/s^2", np.array([20.0, 10.0])) == -20
    assert felt_floor_db("m/s^2", np.array([70.0]), np.array([80.0])) == 30
    assert felt_floor_db("1", np.array([30.0, 10.0])) == -20


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
