"""Rejection of recordings of materials that were not trained on."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.evaluation import classifier_features, mean_interval, wilson
from tactogram.workflows import LoadedRun, ProgressCallback, SurfaceIndex, surface_vector
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.task_kind import AnswerForm, Answers, Figure, Judgement, Question, TaskKind

KEPT = 0.95
"""Share of known recordings at which the share of refused ones is read."""


def _nearest_spectrum(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    """Return the distance to the nearest mean of `classifier_features`; the threshold keeps 95 % of the validation."""
    train = opened.train
    features = classifier_features([example.signal for example in train])
    names = np.array([str(example.material) for example in train])
    means = np.stack([features[names == name].mean(0) for name in opened.materials])
    places = [opened.materials.index(name) for name in names]
    scale = (features - means[places]).std(0)
    scale[scale == 0] = 1.0

    def distances(signals: Sequence[Any]) -> NDArray[np.float64]:
        differences = (classifier_features(signals)[:, None] - means) / scale
        nearest: NDArray[np.float64] = np.sqrt((differences**2).mean(2)).min(1)
        return nearest

    held = [example.signal for example in opened.examples("validation")]
    calibrated = np.sort(distances(held or [example.signal for example in train]))
    threshold = calibrated[min(len(calibrated) - 1, int(np.ceil((len(calibrated) + 1) * KEPT)) - 1)]
    strangeness = distances([question.given["vibration"] for question in questions])
    return {
        question.id: np.array([distance, float(distance > threshold)])
        for question, distance in zip(questions, strangeness, strict=True)
    }


class Rejection(TaskKind):
    """Questions are test recordings of known and of unknown materials."""

    name, rank, version = "rejection", 2, 2
    main = ("auroc", "higher")
    baselines = MappingProxyType({"nearest_spectrum": _nearest_spectrum})
    given = "a recording, of a known material or not"
    asked = "how strange it is, and whether it is refused"

    def check(self, opened: OpenTask) -> None:
        """Refuse a test part without known or without unknown materials."""
        known = [name in opened.materials for name in opened.counts("test")]
        if all(known) or not any(known):
            raise ParameterError(
                f"{opened.task.name}: the test part must hold recordings of materials that are trained on, and of "
                "others"
            )

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return strangeness and verdict."""
        return AnswerForm(
            "strangeness",
            "how unlike all known materials it is, any scale, and 1 if refused, else 0: shape (2,)",
        )

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return the distance to the nearest known recording over the threshold, and whether it exceeds 1."""
        novelty = SurfaceIndex.load(loaded.run).novelty(
            surface_vector(loaded.embedder, question.given["vibration"])
        )
        return np.array([novelty, float(novelty > 1)])

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return the area under the ROC curve and both rates at the model's own threshold, means over surfaces.

        Intervals are over surfaces, known and unknown ones: recordings of one surface are alike.
        """
        far: dict[bool, dict[str, list[float]]] = {True: {}, False: {}}
        kept: dict[bool, dict[str, list[bool]]] = {True: {}, False: {}}
        for example in opened.test:
            name, known = str(example.material), example.material in opened.materials
            strangeness, refused = answers[example.id]
            far[known].setdefault(name, []).append(float(strangeness))
            kept[known].setdefault(name, []).append(refused == 0)
        areas = np.array(
            [[_area(strange, near) for near in far[True].values()] for strange in far[False].values()]
        )
        low, high = mean_interval(areas, least=0.0, most=1.0) or (None, None)
        near = np.sort(np.concatenate(list(far[True].values())))
        threshold = near[min(len(near) - 1, int(np.ceil(KEPT * len(near))) - 1)]

        def rate(title: str, by_surface: Iterable[Sequence[bool]], chance: float) -> Figure:
            shares = [float(np.mean(decisions)) for decisions in by_surface]
            share = wilson(float(np.mean(shares)), len(shares))
            return Figure(
                share.accuracy, "higher", title, floor=1.0, ceiling=chance, low=share.low, high=share.high
            )

        return Judgement(
            {
                "auroc": Figure(
                    float(areas.mean()), "higher", "area under the ROC curve",
                    floor=1.0, ceiling=0.5, low=low, high=high,
                    by_item=dict(zip(far[False], areas.mean(1).tolist(), strict=True)),
                ),
                "unknown_refused": rate(
                    "unknown refused, at the model's threshold",
                    [[not accepted for accepted in held] for held in kept[False].values()],
                    0.0,
                ),
                "known_kept": rate("known kept, at the model's threshold", kept[True].values(), 0.0),
                "refused_at_95": rate(
                    "unknown refused where 95 % of the known are kept",
                    [[distance > threshold for distance in held] for held in far[False].values()],
                    0.05,
                ),
            }
        )  # fmt: skip


def _area(strange: Sequence[float], near: Sequence[float]) -> float:
    """Return the share of pairs in which the unknown recording is the stranger one; ties count half."""
    difference = np.subtract.outer(strange, near)
    return float(np.mean((np.sign(difference) + 1) / 2))


KIND = Rejection()
