"""Words: vibrations or images of asked scores, read by a rater model that neither knows.

The rater model is trained on the validation part: no generator sees that, and the rater sees neither what generators
learn from nor what is asked.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram import models
from tactogram.errors import ParameterError
from tactogram.evaluation import label_fidelity
from tactogram.model import Condition, Example
from tactogram.models import ModelInfo
from tactogram.signal import Image, Signal
from tactogram.training import child_rng, child_seed
from tactogram.workflows import LoadedRun, ProgressCallback
from tactogram_benchmark.data import (
    OpenTask,
    items_of,
    mean_scores,
    rated_examples,
    rated_surfaces,
    ratings_of,
)
from tactogram_benchmark.ignoring import IGNORING, array_of
from tactogram_benchmark.task import TaskOptions, options_of
from tactogram_benchmark.task_kind import AnswerForm, Answers, Content, Figure, Judgement, Question, TaskKind
from tactogram_benchmark.training import trained_for

RATER = "rater"
RESAMPLES = 2000
LEAST_READ = 0.3
"""Least correlation of what a rater model reads from recordings with people's scores: below, it cannot judge others."""


class WordsOptions(TaskOptions):
    """Options of the kind."""

    draws: int = 3
    """Signals or images of each label, of different noises."""


def _nearest(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    words = ratings_of(opened).words
    known = {str(example.item): example for example in rated_examples(opened, "train")}
    held = mean_scores(opened, list(known))
    answers = {}
    for question in questions:
        asked = np.array([question.given["words"].get(word, np.nan) for word in words])
        order = np.argsort(np.nanmean((held - asked) ** 2, axis=1))
        item = list(known)[int(order[int(question.id.rpartition("/")[2])])]  # the next nearest for each draw
        answers[question.id] = array_of(_recorded(known[item]))
    return answers


class Words(TaskKind):
    """Questions are the mean scores of the test items; answers are scored by a rater model."""

    name, rank, version = "words", 6, 2
    main = ("correlation", "higher")
    baselines = MappingProxyType({"nearest_in_words": _nearest, **IGNORING})
    given = "scores in words"
    validation_judges = True
    asked = "a vibration or an image"

    def check(self, opened: OpenTask) -> None:
        """Refuse fewer than three items in a part."""
        for part in ("train", "validation", "test"):
            if len(items := items_of(rated_examples(opened, part))) < 3:
                raise ParameterError(
                    f"{opened.task.name}: the {part} part must hold three rated items, got {len(items)}"
                )

    def fits(self, opened: OpenTask, facts: ModelInfo) -> bool:
        """Return whether the model makes what the store holds from words."""
        of = facts.of(images=not len(opened.store))
        gives = "signal" if len(opened.store) else "image"
        learns = {"recordings", "ratings"} if len(opened.store) else {"images"}
        if rated_surfaces(opened):
            learns.add("both")
        return (
            of.gives == gives and "words" in (*of.needs, *of.instead, *of.takes) and of.learns_from in learns
        )

    def training_items(self, opened: OpenTask) -> list[tuple[Condition, Content]]:
        """Return the rated signals or images of the training part."""
        return [({}, _recorded(example)) for example in rated_examples(opened, "train")]

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return a signal or an image."""
        if not len(opened.store):
            return AnswerForm("image", "pixels 0 to 255, shape (row, column, 3)")
        kind = opened.kind
        return AnswerForm(
            "signal", f"samples at {kind.rate:g} Hz, {kind.unit}, shape ({len(kind.axes)}, time)"
        )

    def questions(self, opened: OpenTask) -> list[Question]:
        """Return the labels, each with several draws."""
        items, words = items_of(rated_examples(opened, "test")), ratings_of(opened).words
        asked = [
            {word: score for word, score in zip(words, row, strict=True) if np.isfinite(score)}
            for row in mean_scores(opened, items).tolist()
        ]
        draws = range(options_of(opened.task, WordsOptions).draws)
        return [
            Question(f"{item}/{draw}", {"words": scores})
            for item, scores in zip(items, asked, strict=True)
            for draw in draws
        ]

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return generated samples or pixels."""
        # The draws of one label differ in noise; those of several labels share it.
        own = child_seed(seed, "benchmark", question.id.rpartition("/")[2])
        content = loaded.generator.generate(dict(question.given), seed=own)
        return content.pixels if isinstance(content, Image) else content.samples

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return how closely the rater model's scores follow those asked."""
        items = items_of(rated_examples(opened, "test"))
        draws = options_of(opened.task, WordsOptions).draws
        rater = _rater(opened, progress)
        words = ratings_of(opened).words

        def said(content: Any) -> list[float]:
            scores = rater.predictor.predict(content)
            return [scores[word] for word in words]

        shown = {
            f"{item}/{draw}": _content(opened, answers[f"{item}/{draw}"])
            for item in items
            for draw in range(draws)
        }
        asked = mean_scores(opened, items)
        told = np.array([[said(shown[f"{item}/{draw}"]) for draw in range(draws)] for item in items])
        follows = label_fidelity(asked, told)
        parts = _parts(asked, told)
        real = {str(e.item): _recorded(e) for e in rated_examples(opened, "test")}
        itself = label_fidelity(asked, np.array([[said(real[item])] for item in items]))
        if itself.correlation < LEAST_READ:
            raise ParameterError(
                f"{opened.task.name}: a rater model of its validation part reads the recordings at a correlation of "
                f"{itself.correlation:.2f} with people, below {LEAST_READ:g}: it needs more rated items"
            )
        low, high = _interval(asked, told)
        scale = ratings_of(opened).scale
        chosen = items[:: max(1, len(items) // 3)][:3]
        return Judgement(
            {
                "correlation": Figure(
                    follows.correlation, "higher",
                    "correlation of the scores that a rater model reads with those asked",
                    floor=itself.correlation, ceiling=0.0, low=low, high=high,
                    by_item=dict(zip(items, parts.tolist(), strict=True)),
                ),
                "slope": Figure(
                    follows.slope, "higher", "change of the scores read per change asked",
                    floor=itself.slope, ceiling=0.0,
                ),
                "error": Figure(
                    follows.error, "lower", "mean absolute error of the scores read",
                    f"of {scale.low:g} to {scale.high:g}",
                    floor=itself.error, ceiling=follows.error_of_others,
                ),
            },
            shown={item: shown[f"{item}/0"] for item in chosen}
            | {f"{item} recorded": real[item] for item in chosen},
        )  # fmt: skip


def _parts(asked: NDArray[np.float64], told: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each label's part of the correlation, shape (label,), whose mean is the correlation."""
    requested = np.broadcast_to((asked - asked.mean(0))[:, None], told.shape)
    heard = told - told.mean((0, 1))
    power = float(np.sqrt(np.sum(requested**2) * np.sum(heard**2)))
    products: NDArray[np.float64] = (requested * heard).sum((1, 2)) * len(asked)
    return products / power if power > 1e-12 else np.zeros(len(asked))


def _interval(asked: NDArray[np.float64], told: NDArray[np.float64]) -> tuple[float, float]:
    """Return the 95 % percentile bootstrap interval of the correlation, over labels (Efron & Tibshirani 1993)."""
    rng = child_rng(0, "benchmark", "interval")
    drawn = (rng.integers(len(asked), size=len(asked)) for _ in range(RESAMPLES))
    correlations = [label_fidelity(asked[places], told[places]).correlation for places in drawn]
    low, high = np.quantile(correlations, [0.025, 0.975])
    return float(low), float(high)


def _rater(opened: OpenTask, progress: ProgressCallback) -> LoadedRun:
    split = opened.split
    photographs = {"train": split.photographs["validation"]} if split.photographs else {}
    judges = replace(split, train=split.validation, validation=(), test=(), photographs=photographs)
    return trained_for(
        replace(opened, split=judges), models.find(RATER), seed=0, progress=progress, folder="judges"
    )


def _recorded(example: Any) -> Signal | Image:
    return example.signal if isinstance(example, Example) else example.image


def _content(opened: OpenTask, answer: NDArray[Any]) -> Signal | Image:
    if not len(opened.store):
        return Image(np.clip(np.round(answer), 0, 255).astype(np.uint8))
    return opened.kind.signal(np.asarray(answer, np.float32))


KIND = Words()
