"""Weights of rated surfaces that scores of words call for."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram.models.texture_flow.rated_words import word_weights

RNG = np.random.default_rng(0)
RATED = RNG.random((12, 3))
NOTHING = np.array([np.nan, np.nan, np.nan])


def test_scores_of_a_rated_surface_are_that_surface():
    for place, scores in enumerate(RATED):
        np.testing.assert_allclose(word_weights(RATED, scores), np.eye(12)[place], atol=1e-12)


def test_the_mix_moves_by_the_ridge_regression_of_what_is_lacking():
    surfaces = RNG.standard_normal((12, 5))
    scores = np.array([0.9, 0.2, 0.4])
    weights = word_weights(RATED, scores)
    x = (RATED - RATED.mean(0)) / RATED.std(0)
    slopes = np.linalg.inv(x.T @ x + 0.1 * 36 * np.eye(3)) @ x.T @ (surfaces - surfaces.mean(0))
    nearest = np.linalg.norm(RATED - scores, axis=1).argmin()
    expected = surfaces[nearest] + (scores - RATED[nearest]) / RATED.std(0) @ slopes
    np.testing.assert_allclose(weights @ surfaces, expected)
    assert weights.sum() == pytest.approx(1)


def test_words_that_are_not_asked_do_not_count():
    scores = np.array([0.9, np.nan, 0.4])
    np.testing.assert_allclose(word_weights(RATED, scores), word_weights(RATED[:, [0, 2]], scores[[0, 2]]))


def test_a_surface_that_lacks_a_word_asked_weighs_nothing():
    rated = RATED.copy()
    rated[4, 0] = np.nan
    scores = np.array([0.9, 0.2, 0.4])
    others = np.delete(np.arange(12), 4)
    weights = word_weights(rated, scores)
    assert weights[4] == 0
    np.testing.assert_allclose(weights[others], word_weights(RATED[others], scores))


def test_no_score_and_no_rated_surface_are_refused():
    for rated, scores in ((RATED, NOTHING), (RATED * np.nan, RATED[0])):
        with pytest.raises(ParameterError, match="at least one that a surface was rated in"):
            word_weights(rated, scores)
