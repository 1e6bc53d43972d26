"""The map of materials: places and mixes."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.signal import Signal
from tactogram_studio.pages.make.mix_view import map_options
from tactogram_studio.pages.make.runs import (
    APART,
    MARGIN,
    NEIGHBOURS,
    levels_db,
    point_of,
    positions,
    weights_at,
)

PLACES = np.array([[0.2, 0.2], [0.8, 0.2], [0.5, 0.8], [0.5, 0.45], [0.2, 0.7]])
unit = st.floats(0, 1)


@given(unit, unit)
def test_weights_are_shares_of_the_nearest(x, y):
    weight = weights_at((x, y), PLACES)

    assert weight.sum() == pytest.approx(1)
    assert np.all(weight >= 0)
    used = np.flatnonzero(weight)
    assert len(used) <= NEIGHBOURS
    distance = np.linalg.norm(PLACES - [x, y], axis=1)
    assert distance[used].max() <= np.sort(distance)[NEIGHBOURS - 1] + 1e-9


@pytest.mark.parametrize("number", range(len(PLACES)))
def test_on_a_material_it_is_that_material(number):
    assert weights_at(PLACES[number], PLACES).tolist() == [float(k == number) for k in range(len(PLACES))]


@given(st.floats(0.05, 0.95), st.floats(0.05, 0.95), st.floats(0, 6.28))
@settings(max_examples=200)
def test_a_small_step_changes_the_mix_a_little(x, y, angle):
    step = 1e-4 * np.array([np.cos(angle), np.sin(angle)])

    change = np.abs(weights_at((x, y), PLACES) - weights_at(np.array([x, y]) + step, PLACES)).max()

    assert change < 0.03  # at most the omitted shares below one percent, and the slope


def test_halfway_between_two_materials_both_have_the_same_weight():
    weight = weights_at((0.5, 0.2), np.array([[0.2, 0.2], [0.8, 0.2]]))

    assert weight == pytest.approx([0.5, 0.5])


def test_similar_spectra_are_close_together():
    rng = np.random.default_rng(0)
    features = np.array([[0, 0, 0, 0], [1, 0, 1, 0], [20, 0, 20, 0], [0, 15, 0, 15]]) + rng.normal(
        0, 0.01, (4, 4)
    )

    place = positions(features)

    def apart(i, j):
        return np.linalg.norm(place[i] - place[j])

    assert apart(0, 1) < apart(0, 3) < apart(2, 3)
    assert place.min() >= MARGIN - 1e-9
    assert place.max() <= 1 - MARGIN + 1e-9
    assert np.array_equal(place, positions(features))


def test_identical_materials_have_separate_places():
    place = positions(np.zeros((3, 5)))

    distances = [np.linalg.norm(place[i] - place[j]) for i in range(3) for j in range(i)]
    assert min(distances) >= 0.99 * APART


def test_one_material_has_a_place():
    assert positions(np.ones((1, 4))).shape == (1, 2)
    assert weights_at((0.1, 0.9), positions(np.ones((1, 4)))).tolist() == [1.0]


def test_the_handle_is_at_the_centre_of_the_weights():
    assert point_of({"a": 1, "b": 1}, "abcde", PLACES) == pytest.approx([0.5, 0.2])
    assert point_of({"c": 0.3}, "abcde", PLACES) == pytest.approx([0.5, 0.8])
    assert point_of({}, "abcde", PLACES) == [0.5, 0.5]


def test_levels_cover_the_shared_bands():
    rng = np.random.default_rng(0)
    signals = [Signal(rng.normal(size=(1, n)), 1000.0, "N") for n in (500, 2000)]

    level = levels_db(signals)

    assert level.shape[0] == 2
    assert level.shape[1] >= 8
    assert np.ptp(level) <= 60


def test_the_chart_has_each_material_at_its_place():
    chart = map_options("abcde", PLACES)

    dots = chart["series"]["data"]
    assert [dot["name"] for dot in dots] == list("abcde")
    np.testing.assert_array_equal([dot["value"] for dot in dots], PLACES)
    assert [dot["label"]["position"] for dot in dots] == ["right", "left", "left", "left", "right"]
