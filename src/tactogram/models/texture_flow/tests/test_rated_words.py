"""Weights of rated surfaces that scores of words call for."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.models.texture_flow.described_surfaces import word_weights

RATED = np.array([[0.1, 0.5], [0.2, 0.5], [0.4, 0.5], [0.9, 0.5]])
"""Nearest neighbours are 0.1, 0.1, 0.2 and 0.5 apart: 0.15 by the median, half of which is the kernel's width."""


def test_weights_are_a_gaussian_of_the_distance_to_the_scores_asked():
    weights = word_weights(RATED, np.array([0.3, 0.5]))
    expected = np.exp(-(np.array([0.2, 0.1, 0.1, 0.6]) ** 2) / (2 * 0.075**2))
    np.testing.assert_allclose(weights, expected / expected.sum())


def test_beyond_all_rated_surfaces_it_is_the_nearest():
    np.testing.assert_allclose(word_weights(RATED, np.array([1.0, 0.5])), [0, 0, 0, 1], atol=1e-3)


def test_words_that_are_not_asked_do_not_count():
    weights = word_weights(RATED, np.array([0.3, np.nan]))
    np.testing.assert_allclose(weights, word_weights(RATED[:, :1], np.array([0.3])))


def test_a_surface_that_lacks_a_word_asked_weighs_nothing():
    rated = np.vstack((RATED, [[0.3, np.nan]]))
    scores = np.array([0.3, 0.5])
    np.testing.assert_allclose(word_weights(rated, scores), [*word_weights(RATED, scores), 0])
    assert word_weights(rated, np.array([0.3, np.nan])).argmax() == 4


def test_one_surface_and_equal_ones_are_all_there_is():
    for count in (1, 3):
        weights = word_weights(np.full((count, 2), 0.4), np.array([0.3, 0.5]))
        np.testing.assert_allclose(weights, 1 / count)


def test_no_score_and_no_rated_surface_are_refused():
    for rated, scores in ((RATED, RATED[0] * np.nan), (RATED * np.nan, RATED[0])):
        with pytest.raises(ParameterError, match="at least one that a surface was rated in"):
            word_weights(rated, scores)
