"""Retrieval of recordings of one surface, of surfaces that were not trained on."""

from __future__ import annotations

from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation import classifier_features, wilson
from tactogram.model import Example
from tactogram.workflows import LoadedRun, ProgressCallback
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.task_kind import (
    AnswerForm,
    Answers,
    Figure,
    Judgement,
    Question,
    TaskKind,
    mean_figure,
)


def _band_levels(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    trained = classifier_features([example.signal for example in opened.train])
    centre, scale = trained.mean(0), trained.std(0)
    scale[scale == 0] = 1.0
    levels = (classifier_features([question.given["vibration"] for question in questions]) - centre) / scale
    return {question.id: row for question, row in zip(questions, levels, strict=True)}


class Retrieval(TaskKind):
    """Each test recording of an unknown material is searched among the others, by the cosine of embeddings."""

    name, rank, version = "retrieval", 3, 2
    main = ("average_precision", "higher")
    baselines = MappingProxyType({"band_levels": _band_levels})
    given = "recordings of surfaces that were not trained on"
    asked = "an embedding of each"

    def check(self, opened: OpenTask) -> None:
        """Refuse a test part without two recordings of each of two unknown materials."""
        unknown = {n: count for n, count in opened.counts("test").items() if n not in opened.materials}
        if len(unknown) < 2 or min(unknown.values()) < 2:
            raise ParameterError(
                f"{opened.task.name}: the test part must hold two recordings or more of each of two materials or "
                "more that are not trained on"
            )

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return an embedding."""
        return AnswerForm("embedding", "a vector of any one length; near in angle is alike: shape (feature,)")

    def questions(self, opened: OpenTask) -> list[Question]:
        """Return the test recordings of unknown materials."""
        return [Question(example.id, {"vibration": example.signal}) for example in _searched(opened)]

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return the embedding of the recording."""
        return loaded.embedder.embed(question.given["vibration"])

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return mean average precision, and the share whose nearest recording is of the same material.

        Both are means over surfaces, with intervals over these: recordings of one surface are alike.
        """
        searched = _searched(opened)
        vectors = np.stack([np.asarray(answers[example.id], np.float64) for example in searched])
        vectors /= np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12)
        names = np.array([str(example.material) for example in searched])
        likeness = vectors @ vectors.T
        np.fill_diagonal(likeness, -np.inf)
        precision: dict[str, list[float]] = {}
        first: dict[str, list[float]] = {}
        for row, name in enumerate(names.tolist()):
            order = np.argsort(-likeness[row], kind="stable")[:-1]
            same = names[order] == name
            ranks = np.flatnonzero(same) + 1
            precision.setdefault(name, []).append(float(np.mean(np.arange(1, len(ranks) + 1) / ranks)))
            first.setdefault(name, []).append(float(same[0]))
        by_surface = {name: float(np.mean(held)) for name, held in precision.items()}
        nearest = wilson(float(np.mean([np.mean(held) for held in first.values()])), len(first))
        chance = float(np.mean([(names == name).sum() - 1 for name in names])) / (len(names) - 1)
        return Judgement(
            {
                "average_precision": mean_figure(
                    by_surface, "higher", "mean average precision", floor=1.0, ceiling=chance, most=1.0
                ),
                "nearest_right": Figure(
                    nearest.accuracy, "higher", "nearest recording of the same material",
                    floor=1.0, ceiling=chance, low=nearest.low, high=nearest.high,
                ),
            }
        )  # fmt: skip


def _searched(opened: OpenTask) -> list[Example]:
    return [example for example in opened.test if example.material not in opened.materials]


KIND = Retrieval()
