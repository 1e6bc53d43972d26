"""Models over speed and force: barycentric inside, the nearest point outside."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from tactogram.errors import ParameterError
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.texture_map import TextureMap

RATE = 1000.0


def model(power, frequency=100.0):
    angle = 2 * np.pi * frequency / RATE
    made = AutoregressiveModel.from_coefficients(
        [1, -1.8 * np.cos(angle), 0.81], 1.0, rate=RATE, unit="m/s^2"
    )
    return AutoregressiveModel(made.reflection, np.array([[power]]) / made.gain, RATE, "m/s^2", ("z",))


GRID = [(v, f) for v in (50, 100, 200) for f in (0.5, 1.0, 2.0)]
SURFACE = TextureMap([model(v * f, v) for v, f in GRID], GRID)


@settings(deadline=None)
@given(st.floats(50, 200), st.floats(0.5, 2))
def test_weights_inside_are_barycentric(speed, force):
    weights = SURFACE.weights(speed, force)
    assert weights.sum() == pytest.approx(1)
    assert weights.min() >= 0
    assert np.count_nonzero(weights) <= 3
    np.testing.assert_allclose(weights @ SURFACE.conditions, [speed, force], rtol=1e-6)


@settings(deadline=None)
@given(st.floats(0, 1000), st.floats(0, 20))
def test_outside_is_the_nearest_point_of_the_hull(speed, force):
    """The hull of a grid is a rectangle, where nearest is clamping each by itself."""
    expected = [np.clip(speed, 50, 200), np.clip(force, 0.5, 2)]
    np.testing.assert_allclose(SURFACE.weights(speed, force) @ SURFACE.conditions, expected, rtol=1e-6)


def test_recorded_conditions_are_the_recorded_models():
    for (speed, force), one in zip(GRID, SURFACE.models, strict=True):
        assert SURFACE.at(speed, force).power[0] == pytest.approx(one.power[0], rel=1e-6)


def test_corner_of_a_triangular_hull_is_cut():
    surface = TextureMap([model(1), model(2), model(3)], [(0, 0), (100, 0), (0, 1)])
    np.testing.assert_allclose(surface.weights(100, 1), [0, 0.5, 0.5])


def test_left_out_is_the_median():
    np.testing.assert_allclose(SURFACE.weights() @ SURFACE.conditions, [100, 1.0])


def test_speed_alone_is_a_line():
    surface = TextureMap([model(1), model(3), model(2)], [(50, np.nan), (200, np.nan), (100, np.nan)])
    np.testing.assert_allclose(surface.weights(speed_mm_s=150), [0, 0.5, 0.5])
    np.testing.assert_allclose(surface.weights(speed_mm_s=500), [0, 1, 0])
    with pytest.raises(ParameterError, match="force_n is unknown"):
        surface.weights(force_n=1.0)


def test_conditions_on_a_slanted_line_are_a_line():
    surface = TextureMap([model(1), model(2), model(3)], [(0, 0), (100, 1), (200, 2)])
    np.testing.assert_allclose(surface.weights(150, 1.5), [0, 0.5, 0.5])


def test_one_model_is_itself_everywhere():
    surface = TextureMap([model(1)], [(np.nan, np.nan)])
    assert surface.at() is surface.models[0]
    known = TextureMap([model(1)], [(100, 1)])
    assert known.at(5, 9) is known.models[0]


def test_given_triangles_are_used():
    points = [(0, 0), (1, 0), (0, 1), (1, 1)]
    other = [[0, 1, 3], [0, 3, 2]], [[0, 1, 2], [1, 2, 3]]
    weights = [TextureMap([model(1)] * 4, points, triangles=t).weights(0.5, 0.5) for t in other]
    np.testing.assert_allclose(weights, [[0.5, 0, 0, 0.5], [0, 0.5, 0.5, 0]])


@pytest.mark.parametrize(
    ("conditions", "options", "message"),
    [
        ([(1, 1)], {}, "2 models, 2"),
        ([(1, 1), (1, 1)], {}, "same speed and force"),
        ([(1, 1), (np.nan, 2)], {}, "for every model or for none"),
        ([(1, 1), (-1, 2)], {}, "finite and >= 0"),
    ],
)
def test_conditions_that_make_no_map_are_refused(conditions, options, message):
    with pytest.raises(ParameterError, match=message):
        TextureMap([model(1), model(2)], conditions, **options)


@pytest.mark.parametrize("speed", [-1, np.nan, np.inf])
def test_speed_that_makes_no_sense_is_refused(speed):
    with pytest.raises(ParameterError, match="speed_mm_s must be finite"):
        SURFACE.weights(speed, 1.0)
