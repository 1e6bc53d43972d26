"""Ratings: a question of steps per word."""

import pytest

from tactogram.errors import ParameterError


def test_each_word_of_each_stimulus_is_asked_in_steps(make_study):
    study = make_study({"kind": "rating", "words": ["rough", "dry"], "low": 1, "high": 5})
    [word] = [study.design.word_question("dry", study.all_stimuli[0]).question]
    assert (word.id, word.kind, word.low, word.high) == ("dry", "steps", 1, 5)


def test_a_scale_without_steps_is_refused(make_study):
    with pytest.raises(ParameterError, match="rating needs low < high, got 7 and 7"):
        make_study({"kind": "rating", "words": ["rough"], "low": 7, "high": 7})
