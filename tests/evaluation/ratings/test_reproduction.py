"""Errors of what is felt of generated signals, and the tests: as printed, by rater and by target."""

import numpy as np
import pytest
from scipy import stats

from tactogram.datasets.ratings.ratings import Ratings, Scale
from tactogram.errors import DataError, ParameterError
from tactogram.evaluation.ratings.reproduction import constant_error, label_fidelity, reproduction

WORDS = ("rough", "sticky")
SCALE = Scale("any", -50.0, 50.0)
TARGETS = {f"p{n}": np.array([n, -n], float) for n in range(6)}


def answers(offsets, *, raters=5, seed=0, leave_out=()):
    """Each rater errs by the condition's offset, and noise of their own."""
    rng = np.random.default_rng(seed)
    rows = [
        (f"r{r}", f"{condition}/{target}", word, TARGETS[target][w] + offset + 0.3 * rng.standard_normal())
        for condition, offset in offsets.items()
        for target in TARGETS
        if f"{condition}/{target}" not in leave_out
        for r in range(raters)
        for w, word in enumerate(WORDS)
    ]
    rater, item, word, score = zip(*rows, strict=True)
    return Ratings(rater, item, word, np.array(score), SCALE, words=WORDS)


def judged(ratings, conditions=("sensor", "A", "B")):
    return reproduction(ratings, TARGETS, conditions=conditions, told_by="simulated raters")


def test_errors_are_to_the_target_of_each_condition():
    """Hatori & Takemura 2023, Sec. V-A: "the mean absolute error between the tactile evaluation points"."""
    figures = judged(answers({"sensor": 3.0, "A": 1.0, "B": 1.0})).as_dict()
    rows = figures["conditions"]
    assert list(rows) == ["sensor", "A", "B"]
    assert rows["sensor"]["mae"] == pytest.approx(3.0, abs=0.1)
    assert rows["A"]["mae"] == pytest.approx(1.0, abs=0.1)
    assert rows["A"]["n"] == 6 * 5 * 2
    assert figures["told_by"] == "simulated raters"


def test_test_as_printed_takes_every_answer_as_independent_and_by_rater_each_rater_once():
    """Hatori & Takemura 2023, Sec. V-A: "Student's t-tests were conducted on the errors for each column"."""
    found = judged(answers({"sensor": 1.05, "A": 1.0}))
    tests = found.as_dict()["tests"]
    [printed], [by_rater] = tests["as_printed"], tests["by_rater"]
    sensor, a = found.errors["sensor"], found.errors["A"]
    assert printed["p"] == pytest.approx(stats.ttest_ind(sensor.ravel(), a.ravel()).pvalue)
    assert by_rater["p"] == pytest.approx(stats.ttest_rel(sensor.mean((0, 2)), a.mean((0, 2))).pvalue)
    assert printed["difference"] == pytest.approx(sensor.mean() - a.mean())


def test_a_rater_model_is_one_rater_and_has_no_test_by_rater():
    tests = judged(answers({"sensor": 3.0, "A": 1.0}, raters=1)).as_dict()["tests"]
    assert tests["by_rater"] is None
    assert tests["by_target"][0]["p"] < 0.01


def test_a_condition_without_all_targets_is_shown_and_not_tested():
    ratings = answers({"sensor": 3.0, "A": 1.0, "B": 1.0}, leave_out=("B/p0",))
    figures = judged(ratings).as_dict()
    assert figures["incomplete"] == ["B"]
    assert figures["conditions"]["B"]["targets"] == 5
    assert {(p["first"], p["second"]) for p in figures["tests"]["as_printed"]} == {("sensor", "A")}


def test_what_is_no_condition_or_no_target_is_refused():
    ratings = answers({"sensor": 3.0})
    with pytest.raises(DataError, match="CONDITION/TARGET with a condition of A, got sensor/p0"):
        judged(ratings, conditions=("A",))
    with pytest.raises(DataError, match="sensor/p1: target must be one of p0"):
        reproduction(ratings, {"p0": TARGETS["p0"]}, conditions=("sensor",), told_by="people")


def test_constant_guess_is_the_targets_mean():
    targets = {"a": np.array([1.0, 5.0]), "b": np.array([3.0, 5.0])}
    assert constant_error(targets) == pytest.approx(0.5)


def test_what_repeats_its_label_follows_it():
    asked = np.array([[0.0, 0.2], [0.5, 0.4], [1.0, 0.9]])
    found = label_fidelity(asked, np.repeat(asked[:, None], 4, 1))
    assert found.error == 0
    assert found.correlation == pytest.approx(1)
    assert found.slope == pytest.approx(1)
    assert found.by_word == pytest.approx((1, 1))
    others = [np.abs(asked[a] - asked[b]).mean() for a in range(3) for b in range(3) if a != b]
    assert found.error_of_others == pytest.approx(np.mean(others))


def test_what_ignores_its_label_has_one_error_for_all_and_no_correlation():
    """A mean-only answer errs little, and follows nothing."""
    asked = np.random.default_rng(0).random((12, 10))
    found = label_fidelity(asked, np.broadcast_to(asked.mean(0), (12, 8, 10)))
    assert found.correlation == pytest.approx(0, abs=1e-9)
    assert found.slope == pytest.approx(0, abs=1e-9)
    assert found.error == pytest.approx(found.error_of_others)


def test_a_word_answered_the_wrong_way_round_is_seen():
    asked = np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]])
    said = np.stack([asked[:, 0], 1 - asked[:, 1]], 1)[:, None]
    assert label_fidelity(asked, said).by_word == pytest.approx((1, -1))
    assert label_fidelity(asked, said).correlation == pytest.approx(0)


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ParameterError, match="at least 3 labels"):
        label_fidelity(np.zeros((2, 3)), np.zeros((2, 1, 3)))


def test_a_hair_the_right_way_beside_much_noise_is_no_following():
    """Means over the same noises would correlate by 1."""
    rng = np.random.default_rng(0)
    asked = rng.random((12, 10))
    said = 0.01 * asked[:, None] + rng.standard_normal((1, 8, 10))
    found = label_fidelity(asked, said)
    assert abs(found.correlation) < 0.05
    assert found.slope == pytest.approx(0.01)
