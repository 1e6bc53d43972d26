"""Descriptions of all measures of a generator, by their names in results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tactogram.evaluation.generation.comparison import BetterDirection
from tactogram.evaluation.measures import signal_measures


@dataclass(frozen=True)
class MeasureInfo:
    """Description of a measure, for tables."""

    title: str
    better: BetterDirection = "lower"
    unit: str = ""


EMBEDDING_MEASURES: Mapping[str, MeasureInfo] = {
    "frechet_distance": MeasureInfo("Fréchet distance in the embedding"),
    "precision": MeasureInfo("precision: share of the generated that lies among the real", "higher"),
    "recall": MeasureInfo("recall: share of the real that lies among the generated", "higher"),
    "density": MeasureInfo("density of the real around the generated", "higher"),
    "coverage": MeasureInfo("coverage: share of the real with generated nearby", "higher"),
    "two_sample_accuracy": MeasureInfo("nearest-neighbour two-sample accuracy"),
}
MEMORY_MEASURES: Mapping[str, MeasureInfo] = {
    "memorised_share": MeasureInfo("share nearer to the training data than unseen recordings"),
    "training_correlation": MeasureInfo("largest correlation with the training data, median"),
}
CLASSIFIER_MEASURES: Mapping[str, MeasureInfo] = {
    "recognised_accuracy": MeasureInfo("classified correctly by the stroke_cnn trained on real", "higher"),
    "tested_on_generated_accuracy": MeasureInfo(
        "classified correctly by a discriminant trained on real", "higher"
    ),
    "trained_on_generated_accuracy": MeasureInfo(
        "real classified correctly by a discriminant trained on it", "higher"
    ),
}


def describe_measures() -> dict[str, MeasureInfo]:
    """Return the description of every measure, by its name in results."""
    signals = {
        name: MeasureInfo(measure.title, unit="" if measure.unit == "1" else measure.unit)
        for name, measure in signal_measures().items()
    }
    return signals | {**EMBEDDING_MEASURES, **CLASSIFIER_MEASURES, **MEMORY_MEASURES}
