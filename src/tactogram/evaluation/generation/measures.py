"""Measures of a generator beyond those of two sets of signals, by their names in results."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from tactogram.evaluation.generation.comparison import BetterDirection
from tactogram.evaluation.measures import SIGNAL_MEASURES


@dataclass(frozen=True)
class MeasureInfo:
    """Description of a measure, for tables."""

    title: str
    better: BetterDirection


EMBEDDING_MEASURES: Mapping[str, MeasureInfo] = {
    "frechet_distance": MeasureInfo("Fréchet distance in the embedding", "lower"),
    "precision": MeasureInfo("precision: share of the generated that lies among the real", "higher"),
    "recall": MeasureInfo("recall: share of the real that lies among the generated", "higher"),
    "density": MeasureInfo("density of the real where the generated lie", "higher"),
    "coverage": MeasureInfo("coverage: share of the real that has generated near it", "higher"),
    "two_sample_accuracy": MeasureInfo("nearest-neighbour two-sample accuracy", "lower"),
}
MEMORY_MEASURES: Mapping[str, MeasureInfo] = {
    "memorised_share": MeasureInfo("share nearer to the training data than unseen recordings", "lower"),
    "training_correlation": MeasureInfo("largest correlation with the training data, median", "lower"),
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
TITLES: Mapping[str, str] = {name: measure.title for name, measure in SIGNAL_MEASURES.items()} | {
    name: facts.title
    for group in (EMBEDDING_MEASURES, CLASSIFIER_MEASURES, MEMORY_MEASURES)
    for name, facts in group.items()
}
"""For people to read, by JSON name."""
