"""Mixing: signals between two materials, at weights between them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation import OVERALL, positions
from tactogram.models import ModelInfo
from tactogram.signal import Signal, resample
from tactogram.training import child_seed
from tactogram.workflows import LoadedRun, ProgressCallback
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.task import TaskOptions, options_of
from tactogram_benchmark.task_kind import (
    AnswerForm,
    Answers,
    Figure,
    Judgement,
    Question,
    TaskKind,
    mean_figure,
)


class MixingOptions(TaskOptions):
    """Options of the kind."""

    pairs: tuple[tuple[str, str], ...]
    steps: int = 6
    """Weights of the second material, from 0 to 1."""
    signals: int = 4
    """Signals of each weight."""
    seconds: float = 4.0


class Mixing(TaskKind):
    """Signals are placed on the line between recordings of the two materials."""

    name, rank, version = "mixing", 5, 3
    main = ("position_error", "lower")
    given = "weights of two materials"
    asked = "a signal"

    def check(self, opened: OpenTask) -> None:
        """Refuse pairs of materials that are not trained on, or with fewer than two test recordings."""
        tested = opened.counts("test")
        for name in {name for pair in options_of(opened.task, MixingOptions).pairs for name in pair}:
            if name not in opened.materials or tested[name] < 2:
                raise ParameterError(
                    f"{opened.task.name}: {name} needs training recordings and two or more test recordings"
                )

    def fits(self, opened: OpenTask, facts: ModelInfo) -> bool:
        """Return whether the model generates signals of materials."""
        return facts.task == "generation" and facts.gives == "signal" and facts.needs == ("material",)

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return a signal."""
        kind = opened.kind
        return AnswerForm(
            "signal",
            f"samples at {kind.rate:g} Hz, {kind.unit}, shape ({len(kind.axes)}, time), as long as asked or longer",
        )

    def questions(self, opened: OpenTask) -> list[Question]:
        """Return the mixes, each of several signals."""
        options = options_of(opened.task, MixingOptions)
        questions = []
        for start, end in options.pairs:
            for weight in np.linspace(0, 1, options.steps).round(6).tolist():
                for draw in range(options.signals):
                    mix = {start: round(1 - weight, 6), end: weight}
                    questions.append(
                        Question(f"{start}+{end}/{weight:g}/{draw}", {"material": mix}, options.seconds)
                    )
        return questions

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return generated samples."""
        own = child_seed(seed, "benchmark", question.id)
        signal = loaded.generator.generate(dict(question.given), seconds=question.seconds, seed=own)
        if not isinstance(signal, Signal):
            raise ParameterError(f"{loaded.facts.name} generates images, not signals")
        return (signal if signal.rate == opened.kind.rate else resample(signal, opened.kind.rate)).samples

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return how far steps are from their weight along the line, and how many pairs move one way.

        The ceiling of the distance is that of the half-way mix for every weight.
        """
        options, kind = options_of(opened.task, MixingOptions), opened.kind
        weights = np.linspace(0, 1, options.steps).round(6)
        recorded = {name: [e.signal for e in held] for name, held in opened.by_material("test").items()}
        error, monotone, half, off = {}, [], [], []
        for number, (start, end) in enumerate(options.pairs, 1):
            mixes = [
                [
                    kind.signal(np.asarray(answers[f"{start}+{end}/{weight:g}/{draw}"], np.float32))
                    for draw in range(options.signals)
                ]
                for weight in weights.tolist()
            ]
            ladder = positions(mixes, recorded[start], recorded[end], weights=weights)
            column = ladder.columns.index(OVERALL)
            placed = ladder.position[:, column]
            error[f"{start}+{end}"] = float(np.mean(np.abs(np.clip(placed, -1, 2) - weights)))
            monotone.append(bool(ladder.monotone[column]))
            half.append(min(1.0, abs(float(ladder.half_weight[column]) - 0.5)))
            off.append(float(ladder.off_line[:, column].max()))
            progress("place mixes", number, len(options.pairs))
        return Judgement(
            {
                "position_error": mean_figure(
                    error, "lower",
                    "mean distance of a mix from its weight along the line between the recordings",
                    floor=0.0, ceiling=float(np.mean(np.abs(weights - 0.5))),
                ),
                "one_way": Figure(
                    float(np.mean(monotone)), "higher", "pairs that move one way", floor=1.0, ceiling=0.0
                ),
                "half_way": Figure(
                    float(np.mean(half)), "lower", "distance of the half-way weight from 0.5",
                    floor=0.0, ceiling=0.5,
                ),
                "off_line": Figure(
                    float(np.mean(off)), "lower", "largest distance from the line, of the ends' distance", floor=0.0
                ),
            },
            shown={
                f"{start}+{end}/0.4": kind.signal(np.asarray(answers[f"{start}+{end}/0.4/0"], np.float32))
                for start, end in options.pairs[:2]
                if f"{start}+{end}/0.4/0" in answers
            },
        )  # fmt: skip


KIND = Mixing()
