"""Geometry Score: difference between the holes of two sets of points, a measure of generators of pictures.

Computed with gudhi. The package piq has the measure, too, but draws landmarks from fresh entropy at every call, so that
no figure of it can be repeated.

References
----------
V. Khrulkov, I. Oseledets, "Geometry Score: A Method For Comparing Generative Adversarial Networks", ICML 2018.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from tactogram.errors import MissingExtraError, ParameterError

LANDMARKS = 32
GAMMA = 1 / 8
DRAWS = 100
"""Of the example in the authors' code for 1000 points. Their default, 64 landmarks and 1/128 per 5000 points, sees no
hole in the few hundred points that a recorded data set has."""
MOST = 100
"""Numbers of holes that are counted; the authors' i_max."""

Array = NDArray[np.float64]


def geometry_score(one: Array, other: Array, *, draws: int = DRAWS, seed: int = 0) -> float:
    """Return the squared distance between the `relative_living_times` of two sets (Algorithm 2), 0 to 2.

    ``one`` and ``other`` are float, shape (point, coordinate): as many points in both, since more points show finer
    holes. Raises `MissingExtraError` without gudhi.
    """
    if len(one) != len(other):
        raise ParameterError(f"both sets must have as many points, got {len(one)} and {len(other)}")
    first, second = (relative_living_times(points, draws=draws, seed=seed) for points in (one, other))
    return float(np.square(first - second).sum())


def relative_living_times(points: Array, *, draws: int = DRAWS, seed: int = 0) -> Array:
    """Return the share of scales at which the points have 0, 1, 2, … holes, shape (`MOST`,) (Algorithm 1, mean).

    Scales go from 0 to `GAMMA` times the largest distance to a landmark; the mean is over ``draws`` of `LANDMARKS`.
    """
    try:
        from gudhi import WitnessComplex
    except ImportError:
        raise MissingExtraError(
            "the Geometry Score needs gudhi, which is not installed: pip install 'tactogram[vision]'"
        ) from None
    points = np.asarray(points, np.float64)
    if points.ndim != 2 or len(points) < LANDMARKS:
        raise ParameterError.must("points", f"be (point, coordinate) of at least {LANDMARKS}", points.shape)
    random = np.random.default_rng(seed)
    times = np.zeros(MOST)
    for _ in range(draws):
        distance = cdist(points, points[random.choice(len(points), LANDMARKS)])  # point, landmark
        order = np.argsort(distance, axis=1)
        table = np.dstack([order, np.take_along_axis(distance, order, axis=1)])
        most = GAMMA * distance.max()
        tree = WitnessComplex(table).create_simplex_tree(max_alpha_square=most, limit_dimension=2)
        tree.compute_persistence(homology_coeff_field=2)
        times += _living(np.minimum(tree.persistence_intervals_in_dimension(1), most), most)
    return times / draws


def _living(holes: Array, most: float) -> Array:
    """Return the share of 0 to ``most`` at which 0, 1, 2, … of ``holes``, (hole, birth and death), are alive."""
    edges = np.unique(np.append(holes, (0.0, most)))
    middles = (edges[:-1] + edges[1:]) / 2
    alive = (
        ((holes[:, :1] <= middles) & (middles < holes[:, 1:])).sum(axis=0) if len(holes) else np.zeros(1, int)
    )
    return np.bincount(np.minimum(alive, MOST - 1), np.diff(edges), minlength=MOST) / most
