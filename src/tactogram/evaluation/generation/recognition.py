"""Classification of generated signals by a classifier of real ones, and the reverse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tactogram.evaluation.generation.comparison import CEILING, FLOOR, NEAREST, OTHERS, TEST, Tables
from tactogram.evaluation.generation.segments import PieceSet
from tactogram.evaluation.measures import Classify, Fit
from tactogram.model import Model
from tactogram.signal import Signal


def measure_classification(
    classifier: Model, cut: Mapping[str, Mapping[str, PieceSet]]
) -> dict[str, dict[str, float | None]]:
    """Return the share of each set's pieces that ``classifier`` classifies correctly; the floor is the test pieces.

    None for materials unknown to the classifier.
    """

    def share(material: str, signals: Sequence[Signal]) -> float:
        place = classifier.materials.index(material)
        return float(np.mean([int(np.argmax(classifier.probabilities(s))) == place for s in signals]))

    columns = [column for column in cut if column not in (TEST, OTHERS)]
    table: dict[str, dict[str, float | None]] = {}
    for material in cut[TEST]:
        if material not in classifier.materials:
            table[material] = dict.fromkeys((*columns, CEILING, NEAREST))
            continue
        table[material] = _chance(len(cut[TEST]))
        for column in columns:
            tested = cut[TEST if column == FLOOR else column][material]
            table[material][column] = share(material, tested.signals)
    return table


def measure_transfer(fit: Fit, cut: Mapping[str, Mapping[str, PieceSet]]) -> Tables:
    """Return both accuracies between a set and the real one: trained on the set, and tested on it."""

    def trained(part: Mapping[str, PieceSet]) -> Classify:
        signals = [signal for pieces in part.values() for signal in pieces.signals]
        return fit(signals, [material for material, pieces in part.items() for _ in pieces.signals])

    tables: Tables = {
        name: {material: {} for material in cut[TEST]}
        for name in ("tested_on_generated_accuracy", "trained_on_generated_accuracy")
    }
    on_real = trained(cut[FLOOR])
    for column, part in cut.items():
        if column in (TEST, OTHERS):
            continue
        on_set = on_real if column == FLOOR else trained(part)
        for material, pieces in part.items():
            real = cut[TEST][material]
            comparisons = (on_real, real if column == FLOOR else pieces), (on_set, real)
            for table, (classify, tested) in zip(tables.values(), comparisons, strict=True):
                answers = classify(tested.signals)
                table[material][column] = float(np.mean([answer == material for answer in answers]))
    for table in tables.values():
        for row in table.values():
            row.update(_chance(len(cut[TEST])))
    return tables


def _chance(materials: int) -> dict[str, float | None]:
    return {CEILING: 1 / materials, NEAREST: None}
