"""Classification accuracy by window and by recording, with confusion counts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from tactogram.errors import ParameterError
from tactogram.model import Example, Model
from tactogram.statistics import pooled


@dataclass(frozen=True, eq=False)
class ClassificationResult:
    """Confusion counts of a classifier on recordings absent from its training.

    ``windows`` and ``recordings`` have shape (true class, answered class), in the order of ``materials``; a recording
    is classified by its windows' pooled probabilities. ``candidates``, of the same shape, counts the recordings among
    whose candidates (`tactogram.model.Model.candidates`) a class is; zeros if the classifier has none.
    """

    materials: tuple[str, ...]
    windows: NDArray[np.int64]
    recordings: NDArray[np.int64]
    candidates: NDArray[np.int64]

    @property
    def window_accuracy(self) -> float:
        """Share of windows classified correctly, 0..1."""
        return float(np.trace(self.windows) / self.windows.sum())

    @property
    def recording_accuracy(self) -> float:
        """Share of recordings classified correctly, 0..1."""
        return float(np.trace(self.recordings) / self.recordings.sum())

    @property
    def recording_interval(self) -> tuple[float, float]:
        """Wilson's 95 % interval of the recording accuracy (Wilson 1927), recordings taken as independent."""
        test = binomtest(int(np.trace(self.recordings)), int(self.recordings.sum()))
        interval = test.proportion_ci(0.95, method="wilson")
        return float(interval.low), float(interval.high)

    @property
    def candidate_facts(self) -> dict[str, float] | None:
        """Share of recordings whose class is among the candidates, and candidates per recording; None without any."""
        if not self.candidates.any():
            return None
        recordings = int(self.recordings.sum())
        return {
            "right_among": float(np.trace(self.candidates) / recordings),
            "mean_number": float(self.candidates.sum() / recordings),
        }

    def __add__(self, other: Self) -> ClassificationResult:
        """Return the counts of both, e.g. of two folds."""
        if self.materials != other.materials:
            raise ParameterError("results of different classes cannot be added")
        return ClassificationResult(
            self.materials,
            self.windows + other.windows,
            self.recordings + other.recordings,
            self.candidates + other.candidates,
        )

    def as_dict(self) -> dict[str, Any]:
        """Return the figures as JSON types, under the names that the command line documents."""
        return {
            "window_accuracy": self.window_accuracy,
            "recording_accuracy": self.recording_accuracy,
            "recording_accuracy_95": list(self.recording_interval),
            "windows": int(self.windows.sum()),
            "recordings": int(self.recordings.sum()),
            "candidates": self.candidate_facts,
            "chance": 1 / len(self.materials),
            "per_material": {
                name: {
                    "window_accuracy": _share(self.windows, row),
                    "recording_accuracy": _share(self.recordings, row),
                    "recordings": int(self.recordings[row].sum()),
                }
                for row, name in enumerate(self.materials)
            },
            "materials": list(self.materials),
            "confusion_windows": self.windows.tolist(),
            "confusion_recordings": self.recordings.tolist(),
        }


def evaluate_classifier(
    classifier: Model,
    examples: Sequence[Example],
    *,
    on_example: Callable[[], None] = lambda: None,
) -> ClassificationResult:
    """Classify every window of ``examples`` and count the answers."""
    classes = len(classifier.materials)
    windows = np.zeros((classes, classes), np.int64)
    recordings, candidates = np.zeros_like(windows), np.zeros_like(windows)
    for example in examples:
        if example.material not in classifier.materials:
            raise ParameterError(
                f"recording {example.id} is of {example.material!r}, which the classifier does not know"
            )
        true = classifier.materials.index(example.material)
        probabilities = classifier.window_probabilities(example.signal)  # window, material
        np.add.at(windows[true], probabilities.argmax(axis=1), 1)
        together = pooled(probabilities)
        recordings[true, together.argmax()] += 1
        for name in classifier.candidates(together) or ():
            candidates[true, classifier.materials.index(name)] += 1
        on_example()
    return ClassificationResult(classifier.materials, windows, recordings, candidates)


def _share(counts: NDArray[np.int64], row: int) -> float | None:
    total = int(counts[row].sum())
    return float(counts[row, row] / total) if total else None
