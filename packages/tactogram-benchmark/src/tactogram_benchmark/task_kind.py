"""Kind of a task: its questions, answers as arrays by question, and how these are judged."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, model_validator
from pydantic.dataclasses import dataclass as checked_dataclass

from tactogram.errors import ParameterError
from tactogram.evaluation import mean_interval
from tactogram.model import Condition
from tactogram.models import ModelInfo
from tactogram.plugins import PluginGroup
from tactogram.signal import Image, Signal
from tactogram.workflows import LoadedRun, ProgressCallback
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.task import BenchmarkTask

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


TASK_KINDS = PluginGroup(
    "kind of a task", "tactogram_benchmark.kinds", "tactogram.task_kinds", "TACTOGRAM_TASK_KINDS"
)
"""Modules with a ``KIND``, a `TaskKind`."""


POOLED = 5
"""Fewest items of a group whose value is kept where those of items may not be."""


@checked_dataclass(frozen=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class Figure:
    """One figure of an answered task, as results keep it."""

    value: float
    better: Literal["lower", "higher"]
    title: str
    unit: str = ""
    floor: float | None = None
    """Value of real recordings, or the best possible."""
    ceiling: float | None = None
    """Value of other materials, or of chance."""
    low: float | None = None
    """95 % interval over what was asked."""
    high: float | None = None
    by_item: Mapping[str, float] = field(default_factory=dict)
    """Of the main figure: parts whose mean is ``value``, by which models are compared."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.low is not None and self.high is not None and not self.low <= self.high:
            raise ValueError(f"low must be at most high, got {self.low:g} and {self.high:g}")
        if self.by_item and not math.isclose(
            float(np.mean(list(self.by_item.values()))), self.value, rel_tol=1e-6, abs_tol=1e-9
        ):
            raise ValueError("value must be the mean of by_item")
        return self


def mean_figure(
    by_item: Mapping[str, float],
    better: Literal["lower", "higher"],
    title: str,
    unit: str = "",
    *,
    floor: float | None = None,
    ceiling: float | None = None,
    most: float = math.inf,
) -> Figure:
    """Return the mean of values by item, at least 0 and at most ``most``, and its 95 % interval over the items."""
    values = np.array(list(by_item.values()))
    low, high = mean_interval(values, least=0.0, most=most) or (None, None)
    return Figure(float(values.mean()), better, title, unit, floor, ceiling, low, high, by_item)


@dataclass(frozen=True)
class Judgement:
    """Result of `TaskKind.judge`: figures by name, the main one first, and what was left out."""

    figures: Mapping[str, Figure]
    notes: tuple[str, ...] = ()
    shown: Mapping[str, Signal | Image] = field(default_factory=dict)
    """Some answers, and what was recorded, for the page: ``QUESTION`` and ``QUESTION recorded``."""


def _pooled(by_item: Mapping[str, float]) -> dict[str, float]:
    """Return values of groups of items, dealt in the order of their names, whose mean is that of the items."""
    values = [by_item[name] for name in sorted(by_item)]
    count = max(1, len(values) // POOLED)
    return {f"group {n + 1}": sum(values[n::count]) * count / len(values) for n in range(count) if values}


Content = Signal | Image | NDArray[Any]
"""A signal, an image, or scores."""
Baseline = Callable[[OpenTask, Sequence[Question], int], Answers]
"""Answers without a trained model, for a seed."""


class TaskKind(ABC):
    """A kind of task. A module of `tactogram_benchmark.kinds` defines one as ``KIND``."""

    name: str
    """Of its module."""
    version: int = 1
    """Of its questions and figures: a change of either makes it another, and earlier results invalid."""
    rank: int = 100
    """Place of its tasks in tables, the smallest first."""
    main: tuple[str, Literal["lower", "higher"]]
    """Name of the main figure, and whether lower or higher is better."""
    given: str
    """What a model is given, in words; `given_in` for a task whose options say."""
    asked: str
    """What is asked, in words."""
    answered_by: str = "classification"
    """Task of the models that answer."""
    baselines: Mapping[str, Baseline] = MappingProxyType({})
    """By name, ranked like models; those that are models are not among them."""
    validation_judges: bool = False
    """Whether the validation part trains the judge, so that no model may see it."""

    def training_items(self, opened: OpenTask) -> list[tuple[Condition, Content]]:
        """Return each training item as an answer, with its conditions: what `ignoring` answers with."""
        return []

    def given_in(self, task: BenchmarkTask) -> str:
        """Return what a model is given in a task, in words."""
        return self.given

    @abstractmethod
    def check(self, opened: OpenTask) -> None:
        """Refuse a task whose split or options are not of this kind; a `ParameterError` says why."""

    def fits(self, opened: OpenTask, facts: ModelInfo) -> bool:
        """Return whether a model can be trained for a task and answer it."""
        return facts.task == self.answered_by

    def uses_shipped(self, opened: OpenTask, facts: ModelInfo) -> bool:
        """Return whether the model answers with the weights that it comes with, untrained for the task."""
        return False

    @abstractmethod
    def form(self, opened: OpenTask) -> AnswerForm:
        """Return what is asked."""

    def questions(self, opened: OpenTask) -> list[Question]:
        """Return the questions, in a fixed order: by default the test recordings."""
        return [Question(example.id, {"vibration": example.signal}) for example in opened.test]

    @abstractmethod
    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return a trained model's answer."""

    @abstractmethod
    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return the figures of answers, complete and of the right shape."""

    def judged(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return what `judge` does; of a task that is ``aggregate_only`` no answers, and no values of items."""
        whole = self.judge(opened, answers, progress)
        if not opened.task.aggregate_only:
            return whole
        pooled = {name: replace(each, by_item=_pooled(each.by_item)) for name, each in whole.figures.items()}
        return Judgement(pooled, whole.notes)


def kind_of(name: str) -> TaskKind:
    """Return a kind by the name of its module; `ParameterError` if there is none."""
    return TASK_KINDS.definition(name, "KIND", TaskKind)  # type: ignore[type-abstract]
