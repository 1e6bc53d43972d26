"""Classification: the material of a recording."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation import linear_discriminant, wilson
from tactogram.statistics import pooled
from tactogram.workflows import LoadedRun, ProgressCallback
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.task_kind import AnswerForm, Answers, Figure, Judgement, Question, TaskKind

SMALLEST = 1e-6
"""Probability below which an error costs no more: 14 nats."""


def _discriminant(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    train = opened.train
    classify = linear_discriminant([e.signal for e in train], [str(e.material) for e in train])
    predicted = classify([question.given["vibration"] for question in questions])
    return {
        question.id: np.array([float(name == answer) for name in opened.materials])
        for question, answer in zip(questions, predicted, strict=True)
    }


class Classification(TaskKind):
    """Questions are the test recordings; answers, probabilities of the materials of the training part."""

    name, rank = "classification", 1
    main = ("accuracy", "higher")
    baselines = MappingProxyType({"linear_discriminant": _discriminant})
    given = "a recording"
    asked = "the probability of each material"

    def check(self, opened: OpenTask) -> None:
        """Refuse a test recording of a material that is not trained on."""
        if unknown := sorted(opened.counts("test").keys() - set(opened.materials)):
            raise ParameterError(f"{opened.task.name}: no training recording of {', '.join(unknown)}")

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return probabilities of materials."""
        names = opened.materials
        return AnswerForm(
            "probabilities",
            f"the probabilities of {len(names)} materials, shape ({len(names)},), sum 1",
            names,
        )

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return pooled probabilities of the windows."""
        model, signal = loaded.classifier, question.given["vibration"]
        shares = pooled(model.window_probabilities(signal))
        share_of = dict(zip(model.materials, shares, strict=True))
        return np.array([share_of.get(name, 0.0) for name in opened.materials])

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return the accuracy by recording, and the cross-entropy."""
        right, cost = {}, {}
        for example in opened.test:
            column = opened.materials.index(str(example.material))
            shares = np.asarray(answers[example.id], np.float64)
            right[example.id] = float(shares.argmax() == column)
            cost[example.id] = -float(np.log(max(shares[column], SMALLEST)))
        chance = 1 / len(opened.materials)
        accuracy = wilson(float(np.mean(list(right.values()))), len(right))
        return Judgement(
            {
                "accuracy": Figure(
                    accuracy.accuracy, "higher", "recordings classified correctly",
                    floor=1.0, ceiling=chance, low=accuracy.low, high=accuracy.high, by_item=right,
                ),
                "cross_entropy": Figure(
                    float(np.mean(list(cost.values()))), "lower", "cross-entropy", "nat",
                    floor=0.0, ceiling=-float(np.log(chance)),
                ),
            }
        )  # fmt: skip


KIND = Classification()
