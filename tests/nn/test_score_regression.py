"""Scores predicted from features, beside scikit-learn's kernel ridge regression."""

import numpy as np
import pytest
import torch
from sklearn.gaussian_process.kernels import RationalQuadratic
from sklearn.kernel_ridge import KernelRidge

from tactogram.errors import ParameterError
from tactogram.nn.score_regression import RIDGE, ScoreRegression


def rated(count=22):
    """Three features in unlike units, and the scores of two words that follow the first two."""
    z = np.random.default_rng(0).standard_normal((count, 3))
    return torch.tensor(5 + z * [3, 30, 300]), torch.tensor(1 / (1 + np.exp(-z[:, :2])))


def test_scores_are_those_of_kernel_ridge_regression():
    features, scores = rated()
    asked = rated(30)[0][22:]
    x, z = ((each - features.mean(0)) / features.std(0, correction=0) for each in (features, asked))
    width = np.median(torch.pdist(x).numpy())
    kernel = RationalQuadratic(width)
    reference = KernelRidge(alpha=RIDGE, kernel="precomputed").fit(kernel(x), scores - scores.mean(0))
    expected = reference.predict(kernel(z, x)) + scores.mean(0).numpy()
    np.testing.assert_allclose(ScoreRegression(features, scores)(asked), expected, rtol=1e-9)


def test_what_is_unlike_all_examples_gets_their_mean():
    features, scores = rated()
    regression = ScoreRegression(features, scores)
    torch.testing.assert_close(regression(features[:1] + 1e6)[0], scores.mean(0))
    assert regression.loss(features + 1e6, scores).item() == pytest.approx(1)
    assert regression.loss(features, scores).item() < 0.2


def test_the_loss_is_differentiable_in_the_features():
    features, scores = rated()
    regression = ScoreRegression(features, scores)
    asked = (features[:4] + 0.1).requires_grad_()
    assert torch.autograd.gradcheck(lambda x: regression.loss(x, scores[:4]), asked)


@pytest.mark.parametrize("which", ["one", "same scores", "same features"])
def test_examples_that_do_not_differ_are_refused(which):
    features, scores = rated()
    if which == "one":
        features, scores = features[:1], scores[:1]
    elif which == "same scores":
        scores = scores[:1].expand(22, -1)
    else:
        features = features[:1].expand(22, -1)
    with pytest.raises(ParameterError, match="must differ in themselves and in their scores"):
        ScoreRegression(features, scores)
