import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.spectra import (
    band_edges,
    band_sums,
    felt_edges,
    felt_floor_db,
    felt_weight,
)
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
