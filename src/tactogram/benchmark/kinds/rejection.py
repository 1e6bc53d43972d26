"""Rejection of recordings of materials that were not trained on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.benchmark.data import OpenTask
from tactogram.benchmark.questions import AnswerForm, Answers, Question
from tactogram.benchmark.task_kind import Baseline, Figure, Judgement, TaskKind
from tactogram.errors import ParameterError
from tactogram.evaluation.generation.comparison import bootstrap_interval
from tactogram.evaluation.measures import classifier_features, wilson
from tactogram.models import ModelInfo
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun
from tactogram.workflows.training.surface_index import SurfaceIndex, surface_vector

KEPT = 0.95
"""Share of known recordings at which the share of refused ones is read."""


class Rejection(TaskKind):
    """Questions are test recordings of known and of unknown materials."""

    name, rank = "rejection", 2
    main = ("auroc", "higher")
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

    def fits(self, opened: OpenTask, facts: ModelInfo) -> bool:
        """Return whether the model is a classifier: its runs have a search index."""
        return facts.task == "classification"

    @property
    def baselines(self) -> Mapping[str, Baseline]:
        """Distance to the nearest material's mean spectrum."""
        return {"nearest_spectrum": _nearest_spectrum}

    def form(self, opened: OpenTask) -> AnswerForm:
        """Return strangeness and verdict."""
        return AnswerForm(
            "strangeness",
            "how unlike all known materials it is, any scale, and 1 if refused, else 0: shape (2,)",
        )

    def questions(self, opened: OpenTask) -> list[Question]:
        """Return the test recordings."""
        return [Question(example.id, {"vibration": example.signal}) for example in opened.test]

    def answer(self, opened: OpenTask, loaded: LoadedRun, question: Question, seed: int) -> NDArray[Any]:
        """Return the distance to the nearest known recording over the threshold, and whether it exceeds 1."""
        novelty = SurfaceIndex.load(loaded.run).novelty(
            surface_vector(loaded.embedder, question.given["vibration"])
        )
        return np.array([novelty, float(novelty > 1)])

    def judge(self, opened: OpenTask, answers: Answers, progress: ProgressCallback) -> Judgement:
        """Return the area under the ROC curve, and both rates at the model's own threshold."""
        known = [e.id for e in opened.test if e.material in opened.materials]
        unknown = [e.id for e in opened.test if e.material not in opened.materials]
        far = {name: float(answer[0]) for name, answer in answers.items()}
        near = np.sort([far[name] for name in known])
        # An unknown recording's share of known ones that are less strange; ties count half.
        by_item = {
            name: float(np.searchsorted(near, far[name], "left") + np.searchsorted(near, far[name], "right"))
            / (2 * len(near))
            for name in unknown
        }
        values = np.array(list(by_item.values()))
        interval = bootstrap_interval(values) or (None, None)
        threshold = near[min(len(near) - 1, int(np.ceil(KEPT * len(near))) - 1)]
        kept = wilson(float(np.mean([answers[name][1] == 0 for name in known])), len(known))
        refused = wilson(float(np.mean([answers[name][1] != 0 for name in unknown])), len(unknown))
        at = wilson(float(np.mean([far[name] > threshold for name in unknown])), len(unknown))
        return Judgement(
            {
                "auroc": Figure(
                    float(values.mean()), "higher", "area under the ROC curve",
                    floor=1.0, ceiling=0.5, low=interval[0], high=interval[1], by_item=by_item,
                ),
                "unknown_refused": Figure(
                    refused.accuracy, "higher", "unknown refused, at the model's threshold",
                    floor=1.0, ceiling=0.0, low=refused.low, high=refused.high,
                ),
                "known_kept": Figure(
                    kept.accuracy, "higher", "known kept, at the model's threshold",
                    floor=1.0, ceiling=0.0, low=kept.low, high=kept.high,
                ),
                "refused_at_95": Figure(
                    at.accuracy, "higher", "unknown refused where 95 % of the known are kept",
                    floor=1.0, ceiling=0.05, low=at.low, high=at.high,
                ),
            }
        )  # fmt: skip


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
    found = distances([question.given["vibration"] for question in questions])
    return {
        question.id: np.array([distance, float(distance > threshold)])
        for question, distance in zip(questions, found, strict=True)
    }


KIND = Rejection()
