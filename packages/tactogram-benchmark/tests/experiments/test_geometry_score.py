"""Holes of sets whose holes are known."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_benchmark.experiments.geometry_score import geometry_score, relative_living_times


def ring(seed, holes=1, points=200):
    """Circles beside each other, of radius 1 and slightly blurred."""
    random = np.random.default_rng(seed)
    angle, which = random.uniform(0, 2 * np.pi, points), random.integers(0, holes, points)
    at = np.column_stack([np.cos(angle) + 4 * which, np.sin(angle)])
    return at + 0.02 * random.standard_normal(at.shape)


def test_a_circle_has_one_hole_and_two_have_two():
    for holes in (1, 2):
        times = relative_living_times(ring(0, holes), draws=10)
        assert times.sum() == pytest.approx(1)
        assert times.argmax() == holes


def test_sets_of_the_same_shape_are_near_and_others_are_not():
    """Cai et al. 2020, Sec. 5: "evaluating some parameters, such as Geometry Score"."""
    one = ring(0)
    near, far = (geometry_score(one, other, draws=10) for other in (ring(1), ring(1, holes=2)))
    assert near < 0.05 < 0.3 < far
    assert geometry_score(one, one, draws=10) == 0


def test_sets_of_different_size_are_refused():
    with pytest.raises(ParameterError, match="as many points, got 200 and 100"):
        geometry_score(ring(0), ring(1, points=100))
