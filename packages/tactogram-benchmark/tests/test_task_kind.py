"""Kinds of tasks: what perfect, useless and broken answers are worth."""

import numpy as np
import pytest

from tactogram.errors import ParameterError
from tactogram_benchmark.task_kind import check_answers, kind_of


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (None, "expected an answer to each of 12 questions, got none to"),
        (np.full(6, np.nan), "must be finite numbers"),
        (np.full(6, 0.5), r"got the sum 3 and the least 0.5"),
        (np.array([1.5, -0.5, 0, 0, 0, 0]), r"got the sum 1 and the least -0.5"),
        (np.ones(5), r"must be the probabilities of 6 materials, shape \(6,\), sum 1, got shape \(5,\)"),
    ],
)
def test_broken_answers_are_refused(judged, tasks, answer, message):
    opened = tasks.open("name")
    kind = kind_of("classification")
    questions = kind.questions(opened)
    answers = {q.id: np.ones(6) / 6 for q in questions}
    answers[questions[0].id] = answer
    if answer is None:
        del answers[questions[0].id]
    with pytest.raises(ParameterError, match=message):
        check_answers(kind.form(opened), questions, answers, where="answers")


def test_a_task_of_the_wrong_split_is_refused(tasks):
    opened = tasks.open("name")
    with pytest.raises(
        ParameterError, match="must hold recordings of materials that are trained on, and of others"
    ):
        kind_of("rejection").check(opened)
    with pytest.raises(ParameterError, match="two recordings or more of each of two materials"):
        kind_of("retrieval").check(opened)
    with pytest.raises(ParameterError, match="no training recording of"):
        kind_of("classification").check(tasks.open("none"))
    with pytest.raises(ParameterError, match="kind of a task must be one of classification"):
        kind_of("tasting")
