"""Scores of words: what the mean and those of people are worth."""

import pytest

from tactogram_benchmark.data import mean_scores, rated_examples
from tactogram_benchmark.task_kind import kind_of


def test_the_mean_of_scores_is_worth_the_ceiling(judged, tasks):
    mean = kind_of("rating").baselines["mean"]
    found = judged("rate", lambda opened, q: mean(opened, [q], 0)[q.id])[2].figures
    assert found["error"].value == pytest.approx(found["error"].ceiling)


def test_the_scores_of_people_are_worth_an_error_of_0(judged):
    def right(opened, question):
        item = {e.id: e.item for e in rated_examples(opened, "test")}[question.id]
        return mean_scores(opened, [item])[0]

    found = judged("rate", right)[2].figures
    assert found["error"].value == 0
    assert found["rank_correlation"].value == pytest.approx(1)
    assert found["error"].ceiling > 0.3
