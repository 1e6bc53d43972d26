"""Figures of predicted scores, and the map of words."""

import numpy as np
import pytest

from tactogram.evaluation.ratings.figures import prediction_figure, word_map_figure
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


def test_word_map_keeps_distances_where_two_words_are_all_there_is():
    kinds = {
        "plates": {"p1": np.array([1.0, 2.0]), "p2": np.array([6.0, 3.0])},
        "signals": {"s1": np.array([2.0, 7.0])},
        "made": {"p1": np.array([4.0, 6.0])},
    }
    axes = word_map_figure(kinds, WORDS, targets={"made:p1": "plates:p1"}).axes[0]
    [line] = [one for one in axes.lines if one.get_marker() == "None"]
    assert np.hypot(*np.diff(line.get_xydata(), axis=0)[0]) == pytest.approx(5.0)
    assert f"{np.sqrt(25 / 2):.1f}" in [text.get_text() for text in axes.texts]
