"""Recordings generated from words, judged by a rater model."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_benchmark.data import items_of, rated_examples
from tactogram_benchmark.kinds import words


def test_the_correlation_of_words_is_the_mean_of_its_parts(judged):
    rng = np.random.default_rng(2)

    def noise(opened, question):
        return rng.standard_normal((len(opened.kind.axes), 2500)).astype(np.float32)

    opened, _questions, found = judged("words", noise)
    figure = found.figures["correlation"]
    assert np.mean(list(figure.by_item.values())) == pytest.approx(figure.value)
    assert set(figure.by_item) == set(items_of(rated_examples(opened, "test")))
    assert -1 <= figure.low <= figure.value <= figure.high <= 1
    assert figure.floor > figure.value  # the recording itself is read better than noise


def test_a_rater_model_that_cannot_read_recordings_does_not_judge(judged, monkeypatch):
    monkeypatch.setattr(words, "LEAST_READ", 1.1)
    with pytest.raises(
        ParameterError, match=r"at a correlation of 0\.\d\d with people, below 1.1: it needs more"
    ):
        judged("words", lambda opened, question: np.ones((len(opened.kind.axes), 2500), np.float32))
