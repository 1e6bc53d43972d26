"""Errors of what is felt of generated signals, and the tests: as printed, by rater and by target."""

import numpy as np
import pytest
from scipy import stats

from tactogram.datasets.ratings.ratings import Ratings, Scale
from tactogram.errors import DataError
from tactogram.evaluation.ratings.reproduction import constant_error, reproduction

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
    figures = judged(answers({"sensor": 3.0, "A": 1.0, "B": 1.0})).as_dict()
    rows = figures["conditions"]
    assert list(rows) == ["sensor", "A", "B"]
    assert rows["sensor"]["mae"] == pytest.approx(3.0, abs=0.1)
    assert rows["A"]["mae"] == pytest.approx(1.0, abs=0.1)
    assert rows["A"]["n"] == 6 * 5 * 2
    assert figures["told_by"] == "simulated raters"


def test_test_as_printed_takes_every_answer_as_independent_and_by_rater_each_rater_once():
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
