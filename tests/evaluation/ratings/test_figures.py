"""Figure of predicted scores."""

import numpy as np

from tactogram.evaluation.ratings.figures import prediction_figure
from tactogram.evaluation.ratings.prediction import (
    PredictedRatings,
)

WORDS = ("rough", "sticky")


def people(items=30, raters=8, noise=0.5, seed=0):
    rng = np.random.default_rng(seed)
    means = rng.uniform(1, 7, (items, 1, 2))
    return means + noise * rng.standard_normal((items, raters, 2))


def predicted(error=0.2, repeats=2, seed=0):
    cube = people()
    rng = np.random.default_rng(seed)
    truth = np.repeat(cube.mean(1)[None], repeats, axis=0)
    scores = truth + error * rng.choice([-1.0, 1.0], truth.shape)
    constant = np.broadcast_to(truth.mean(1, keepdims=True), truth.shape)
    return PredictedRatings(WORDS, [f"i{n}" for n in range(30)], scores, constant, truth, cube)


def test_every_word_is_shown():
    found = predicted()
    axes = prediction_figure(found, found.as_dict()).axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == list(WORDS)
