"""Regression of scores, some of them missing."""

import numpy as np

from tactogram.models.rater import Config
from tactogram.models.rater.regression import fit_regression

FAST = Config(folds=3, trunk="none")


def test_an_item_that_nobody_scored_in_a_word_is_left_out_of_that_word():
    rng = np.random.default_rng(0)
    x = rng.standard_normal((30, 4))
    y = np.clip(0.5 + 0.1 * x[:, :2], 0, 1)
    holes = y.copy()
    holes[:5, 1] = np.nan
    fitted = [
        fit_regression(
            x, scores, items=[str(n) for n in range(30)], weights=np.ones(30), blocks=(4,), config=FAST,
            rng=np.random.default_rng(0),
        )
        for scores in (y, holes)
    ]  # fmt: skip
    assert np.isfinite(fitted[1].predict(x)).all()
    np.testing.assert_array_equal(fitted[0].predict(x)[:, 0], fitted[1].predict(x)[:, 0])
    np.testing.assert_array_equal(fitted[1].coefficients[:5, 1], 0)
