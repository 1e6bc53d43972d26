"""Clusters of surfaces."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist, squareform

from tactogram.errors import ParameterError
from tactogram.models.ultrasonic_cgan.surfaces import clusters_of, tree_of


def test_clusters_are_those_of_ward_by_hand():
    means = np.array([[0.0, 0.0], [0.1, 0.0], [0.9, 0.9], [0.9, 0.8], [0.5, 0.1]])
    tree = tree_of(means, "ward")
    assert tree[0, 2] == pytest.approx(squareform(pdist(means))[0, 1])
    np.testing.assert_array_equal(clusters_of(tree, 3, items=5), [0, 0, 1, 1, 2])
    np.testing.assert_array_equal(clusters_of(tree, 2, items=5), [0, 0, 1, 1, 0])
    np.testing.assert_array_equal(clusters_of(tree, 1, items=5), [0] * 5)
    np.testing.assert_array_equal(clusters_of(tree, 5, items=5), range(5))
    with pytest.raises(ParameterError, match="at most the 5 surfaces, got 6"):
        clusters_of(tree, 6, items=5)


def test_exactly_as_many_clusters_as_asked_for_even_of_equals():
    means = np.array([[0.0], [1.0], [2.0], [3.0]])
    assert len(set(clusters_of(tree_of(means, "single"), 3, items=4))) == 3
