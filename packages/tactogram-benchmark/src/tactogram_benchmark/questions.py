"""Questions of a task, and answers: arrays by question, from a model or from a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.model import Condition

ROUNDING = 1e-3
"""Of the sum of probabilities."""

Answers = Mapping[str, NDArray[Any]]
"""An array per question: see `AnswerForm`."""


@dataclass(frozen=True, eq=False)
class Question:
    """Conditions that a model is given, and for a signal its length."""

    id: str
    given: Condition
    seconds: float | None = None
    """Length of the signal that is asked, s, or mm over displacement; None if no signal is."""


@dataclass(frozen=True)
class AnswerForm:
    """Array that is asked for each question."""

    what: Literal["probabilities", "strangeness", "embedding", "signal", "image", "scores"]
    text: str
    """The array's shape and unit, in words."""
    names: tuple[str, ...] = ()
    """Of the array's elements: materials, or words."""


def check_answers(form: AnswerForm, questions: Sequence[Question], answers: Answers, *, where: str) -> None:
    """Refuse answers that are incomplete, not finite, or of another shape than asked.

    Raises
    ------
    ParameterError
        Naming the first question at fault.
    """
    for question in questions:
        if question.id not in answers:
            raise ParameterError(
                f"{where}: expected an answer to each of {len(questions)} questions, got none to {question.id!r}"
            )
        answer = np.asarray(answers[question.id])
        if answer.dtype.kind not in "biuf" or not np.isfinite(answer).all():
            raise ParameterError(f"{where}: answer to {question.id!r} must be finite numbers")
        dimensions = {"signal": 2, "image": 3}.get(form.what, 1)
        expected = len(form.names) if form.what in ("probabilities", "scores") else None
        if form.what == "strangeness":
            expected = 2
        if answer.ndim != dimensions or (expected is not None and len(answer) != expected):
            raise ParameterError(
                f"{where}: answer to {question.id!r} must be {form.text}, got shape {answer.shape}"
            )
        if form.what == "probabilities" and (answer.min() < 0 or abs(answer.sum() - 1) > ROUNDING):
            raise ParameterError(
                f"{where}: answer to {question.id!r} must be {form.text}, got the sum {answer.sum():g} and the least "
                f"{answer.min():g}"
            )
