"""Recognition of generated signals: by a classifier of real ones and the reverse, and as copies of training data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.examples import cores
from tactogram.evaluation.generation.comparison import (
    CEILING,
    FLOOR,
    MEMORY_MEASURES,
    NEAREST,
    OTHERS,
    TEST,
    PieceSet,
    Tables,
)
from tactogram.evaluation.measures import Classify, Fit, nearness
from tactogram.model import Model
from tactogram.signal import Signal

SNIPPET_S = 0.5
"""Length of the beginning of each piece that is compared with the training data, s."""


def measure_classification(
    classifier: Model, cut: Mapping[str, Mapping[str, PieceSet]]
) -> dict[str, dict[str, float | None]]:
    """Return the share of each set's pieces that ``classifier`` classifies correctly; the floor is the test pieces.

    None for materials unknown to the classifier.
    """

    def share(material: str, signals: Sequence[Signal]) -> float:
        index = classifier.materials.index(material)
        return float(np.mean([int(np.argmax(classifier.probabilities(s))) == index for s in signals]))

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


def measure_memorisation(
    cut: Mapping[str, Mapping[str, PieceSet]],
    train: Mapping[str, Sequence[Signal]],
    workers: int | None,
    on_part: Callable[[int, int], None],
) -> Tables:
    """Return the nearness of each set to its training data (`evaluation.measures.memorisation`).

    The floor of the share is its chance level for new draws of the same kind, 1 / (n + 1) with n unseen pieces. None
    for materials absent from training.
    """
    columns = [name for name in cut if name not in (TEST, OTHERS, FLOOR)]
    first = next(iter(cut[TEST].values())).signals[0]
    length = min(round(SNIPPET_S * first.rate), len(first))
    if length < 2:
        return {}

    def near(pieces: PieceSet, material: str) -> NDArray[np.float64]:
        long = [signal for signal in train[material] if len(signal) >= length]
        return nearness([s.cut(0, length) for s in pieces.signals], long, seconds=length / first.rate)

    def rows(material: str) -> dict[str, dict[str, float | None]]:
        if material not in train:
            return {name: dict.fromkeys((*columns, FLOOR, CEILING, NEAREST)) for name in MEMORY_MEASURES}
        unseen = near(cut[TEST][material], material)
        generated = {column: near(cut[column][material], material) for column in columns}
        share: dict[str, float | None] = {
            column: float(np.mean(generated[column] > unseen.max())) for column in columns
        }
        median: dict[str, float | None] = {column: float(np.median(generated[column])) for column in columns}
        ends = {CEILING: 1.0, NEAREST: None}
        share[FLOOR], median[FLOOR] = 1 / (len(unseen) + 1), float(np.median(unseen))
        return dict(zip(MEMORY_MEASURES, (share | ends, median | ends), strict=True))

    return tables_of(rows, tuple(cut[TEST]), workers, on_part)


def tables_of(
    rows: Callable[[str], Mapping[str, dict[str, float | None]]],
    materials: Sequence[str],
    workers: int | None,
    on_part: Callable[[int, int], None],
) -> Tables:
    """Return the tables of the rows by measure that ``rows`` returns for each material, in threads."""
    tables: Tables = {}
    with ThreadPoolExecutor(workers or cores()) as pool:
        for done, (material, row) in enumerate(zip(materials, pool.map(rows, materials), strict=True), 1):
            for name, values in row.items():
                tables.setdefault(name, {})[material] = values
            on_part(done, len(materials))
    return tables
