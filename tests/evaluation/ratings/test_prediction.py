"""Errors of predicted scores, and of what they stand beside: constant guesses and people."""

import numpy as np
import pytest

from tactogram.evaluation.ratings.prediction import (
    PredictedRatings,
    one_rater_error,
    prediction_figure,
    split_half_error,
)


def test_every_word_is_shown():
    found = predicted()
    axes = prediction_figure(found, found.as_dict()).axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == list(WORDS)


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


def test_error_is_the_mean_over_items_beside_that_of_a_constant_guess():
    found = predicted()
    figures = found.as_dict()
    assert figures["mean"]["mae"] == pytest.approx(0.2)
    assert figures["per_word"]["rough"]["mae_sd"] == pytest.approx(0, abs=1e-9)
    by_hand = np.abs(found.truth[0] - found.truth[0].mean(0)).mean(0)
    for word, value in zip(WORDS, by_hand, strict=True):
        assert figures["per_word"][word]["constant_mae"] == pytest.approx(value)
        assert figures["per_word"][word]["p_against_constant"] < 1e-3
        assert figures["per_word"][word]["rank_correlation"] > 0.95


def test_a_model_that_says_the_constant_is_not_better_than_it():
    found = predicted()
    same = PredictedRatings(WORDS, found.items, found.constant, found.constant, found.truth, found.cube)
    row = same.as_dict()["mean"]
    assert row["mae"] == row["constant_mae"]
    assert row["p_against_constant"] is None
    assert row["rank_correlation"] is None


def test_items_that_were_not_predicted_count_nowhere():
    found = predicted(repeats=1)
    scores = found.scores.copy()
    scores[0, 20:] = np.nan
    part = PredictedRatings(WORDS, found.items, scores, found.constant, found.truth, found.cube)
    assert part.as_dict()["mean"]["mae"] == pytest.approx(0.2)
    by_hand = np.abs(found.constant - found.truth)[0, :20].mean()
    assert part.as_dict()["mean"]["constant_mae"] == pytest.approx(by_hand)


def test_a_repetition_whose_judges_all_left_a_word_out_has_no_part_in_its_spread():
    found = predicted(repeats=3)
    truth, scores = found.truth.copy(), found.scores.copy()
    scores[2] = truth[2] + 0.4
    truth[0, :, 1] = np.nan
    row = PredictedRatings(WORDS, found.items, scores, found.constant, truth, found.cube).as_dict()[
        "per_word"
    ]
    assert row["sticky"]["mae_sd"] == pytest.approx(np.std([0.2, 0.4], ddof=1))
    assert row["rough"]["mae_sd"] == pytest.approx(np.std([0.2, 0.2, 0.4], ddof=1))


def test_half_of_the_raters_is_as_far_from_the_other_as_their_noise_says():
    """The difference of two means of n / 2 has the variance 4 s² / n."""
    error = split_half_error(people(400, 16, 0.5), rng=np.random.default_rng(0), splits=20)
    np.testing.assert_allclose(error, np.sqrt(2 / np.pi) * np.sqrt(4 / 16) * 0.5, rtol=0.05)


def test_one_rater_is_held_against_the_mean_of_the_others():
    cube = np.array([[[1.0], [3.0], [8.0]]])
    assert one_rater_error(cube)[0] == pytest.approx(np.mean([4.5, 1.5, 6.0]))
    with_hole = np.array([[[1.0], [3.0], [np.nan]]])
    assert one_rater_error(with_hole)[0] == pytest.approx(2.0)


def test_one_rater_for_all_says_nothing_of_agreement():
    assert np.isnan(one_rater_error(people(raters=1))).all()
    assert np.isnan(split_half_error(people(raters=3), rng=np.random.default_rng(0))).all()
