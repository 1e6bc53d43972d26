"""Rating: the scores in words that people give a recording or an image."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import spearmanr

from tactogram.errors import ParameterError
from tactogram.model import Condition, ImageExample
from tactogram.workflows import LoadedRun, ProgressCallback
from tactogram_benchmark.data import OpenTask, items_of, mean_scores, rated_examples, ratings_of
from tactogram_benchmark.ignoring import IGNORING
from tactogram_benchmark.task_kind import (
    AnswerForm,
    Answers,
    Content,
    Figure,
    Judgement,
    Question,
    TaskKind,
    mean_figure,
)


class Rating(TaskKind):
    """Questions are the test recordings or images; items that were rated are in one part."""

    name, rank, version = "rating", 7, 2
    main = ("error", "lower")
    baselines = IGNORING
    given = "a recording or an image"
    asked = "the mean score of people in each word"
    answered_by = "prediction"

    def check(self, opened: OpenTask) -> None:
        """Refuse an item of the test part that is trained on, and fewer than three items."""
        tested = set(items_of(rated_examples(opened, "test")))
        known = {item for part in ("train", "validation") for item in items_of(rated_examples(opened, part))}
        if both := sorted(tested & known):
            raise ParameterError(f"{opened.task.name}: {both[0]} is in the test part and in another")
        if len(tested) < 3:
            raise ParameterError(
                f"{opened.task.name}: needs three rated test items or more, got {len(tested)}"
            )

    def training_items(self, opened: OpenTask) -> list[tuple[Condition, Content]]:
        """Return the mean scores of each training item."""
        return [({}, row) for row in mean_scores(opened, items_of(rated_examples(opened, "train")))]

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return scores."""
        words, scale = ratings_of(opened).words, ratings_of(opened).scale
        return AnswerForm(
            "scores", f"scores from {scale.low:g} to {scale.high:g}, shape ({len(words)},)", tuple(words)
        )

    def questions(self, opened: OpenTask) -> list[Question]:
        """Return the test recordings or images."""
        return [
            Question(e.id, {"image": e.image} if isinstance(e, ImageExample) else {"vibration": e.signal})
            for e in rated_examples(opened, "test")
        ]

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return predicted scores."""
        (content,) = question.given.values()
        said = loaded.predictor.predict(content)
        return np.array([said[word] for word in ratings_of(opened).words])

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return the mean absolute error by item, and the rank correlation over items, mean over words."""
        examples = rated_examples(opened, "test")
        items = items_of(examples)
        said = np.stack(
            [np.mean([answers[e.id] for e in examples if e.item == item], axis=0) for item in items]
        )
        held = mean_scores(opened, items)
        errors = np.nanmean(np.abs(said - held), axis=1)
        guess = np.nanmean(mean_scores(opened, items_of(rated_examples(opened, "train"))), axis=0)
        ranks = [_rank(said[:, word], held[:, word]) for word in range(held.shape[1])]
        scale = ratings_of(opened).scale
        unit = f"of {scale.low:g} to {scale.high:g}"
        return Judgement(
            {
                "error": mean_figure(
                    dict(zip(items, errors.tolist(), strict=True)),
                    "lower", "mean absolute error of the mean scores", unit,
                    floor=0.0, ceiling=float(np.nanmean(np.abs(guess - held))),
                ),
                "rank_correlation": Figure(
                    float(np.mean(ranks)), "higher", "rank correlation over items, mean over words",
                    floor=1.0, ceiling=0.0,
                ),
            }
        )  # fmt: skip


def _rank(said: NDArray[np.float64], held: NDArray[np.float64]) -> float:
    known = np.isfinite(held)
    if np.ptp(said[known]) == 0 or np.ptp(held[known]) == 0:
        return 0.0
    return float(spearmanr(said[known], held[known]).statistic)


KIND = Rating()
