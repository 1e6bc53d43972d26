"""Recognition of generated signals by a classifier of real ones, and the reverse."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from tactogram.evaluation.generation.comparison import CEILING, FLOOR, NEAREST, OTHERS, TEST, Tables
from tactogram.evaluation.generation.segments import PieceSet
from tactogram.evaluation.measures import Fit
from tactogram.model import Classifier
from tactogram.signal import Signal


def measure_classification(
    classifier: Classifier, cut: Mapping[str, Mapping[str, PieceSet]]
) -> dict[str, dict[str, float | None]]:
    """Return the share of each set's pieces that ``classifier`` classifies correctly; the floor is the test pieces.

    None for materials that it does not know.
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
        table[material] = _guessing(len(cut[TEST]))
        for column in columns:
            tested = cut[TEST if column == FLOOR else column][material]
            table[material][column] = share(material, tested.signals)
    return table


def measure_transfer(fit: Fit, cut: Mapping[str, Mapping[str, PieceSet]]) -> Tables:
    """Return both ways of a classifier between a set and the real: trained on it, and tested on it."""

    def trained(part: Mapping[str, PieceSet]) -> Callable[[Sequence[Signal]], Sequence[str]]:
        signals = [signal for held in part.values() for signal in held.signals]
        return fit(signals, [material for material, held in part.items() for _ in held.signals])

    tables: Tables = {
        name: {m: {} for m in cut[TEST]}
        for name in ("tested_on_generated_accuracy", "trained_on_generated_accuracy")
    }
    on_real = trained(cut[FLOOR])
    for column, part in cut.items():
        if column in (TEST, OTHERS):
            continue
        on_it = on_real if column == FLOOR else trained(part)
        for material, held in part.items():
            asked = {
                "tested_on_generated_accuracy": (on_real, cut[TEST][material] if column == FLOOR else held),
                "trained_on_generated_accuracy": (on_it, cut[TEST][material]),
            }
            for name, (classify, tested) in asked.items():
                answers = classify(tested.signals)
                tables[name][material][column] = float(np.mean([answer == material for answer in answers]))
    for table in tables.values():
        for row in table.values():
            row.update(_guessing(len(cut[TEST])))
    return tables


def _guessing(materials: int) -> dict[str, float | None]:
    """Return the ceiling of an accuracy."""
    return {CEILING: 1 / materials, NEAREST: None}
