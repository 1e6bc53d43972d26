import math

import pytest

from tactogram_study.questions import Question


@pytest.mark.parametrize(
    ("values", "example"),
    [
        ({"kind": "choice", "options": [{"value": "r"}, {"value": "l"}]}, "r"),
        ({"kind": "steps", "low": 1, "high": 7}, "1"),
        ({"kind": "vas", "low": -0.5, "high": 1}, "-0.5"),
        ({"kind": "number", "high": 3}, "3"),
        ({"kind": "number", "low": math.nan}, "0"),
        ({"kind": "text"}, "-"),
    ],
)
def test_the_example_of_a_question_is_accepted(values, example):
    question = Question(id="q", text="Q?", **values)
    assert question.example == example
    assert question.accepted(question.example) == example
