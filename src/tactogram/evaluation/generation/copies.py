"""Memorisation check of a generator."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.examples import cores
from tactogram.evaluation.generation.comparison import CEILING, FLOOR, NEAREST, OTHERS, TEST, Tables
from tactogram.evaluation.generation.measures import MEMORY_MEASURES
from tactogram.evaluation.generation.segments import PieceSet
from tactogram.evaluation.measures import nearness
from tactogram.signal import Signal

SNIPPET_S = 0.5
"""Length of the beginning of each piece that is compared with the training data, s."""


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

    def rows(material: str) -> tuple[dict[str, float | None], dict[str, float | None]]:
        if material not in train:
            empty: dict[str, float | None] = dict.fromkeys((*columns, FLOOR, CEILING, NEAREST))
            return empty, dict(empty)
        unseen = near(cut[TEST][material], material)
        made = {column: near(cut[column][material], material) for column in columns}
        share = {column: float(np.mean(made[column] > unseen.max())) for column in columns}
        median = {column: float(np.median(made[column])) for column in columns}
        ends: dict[str, float | None] = {CEILING: 1.0, NEAREST: None}
        share[FLOOR], median[FLOOR] = 1 / (len(unseen) + 1), float(np.median(unseen))
        return share | ends, median | ends

    tables: Tables = {name: {} for name in MEMORY_MEASURES}
    materials = tuple(cut[TEST])
    with ThreadPoolExecutor(workers or cores()) as pool:
        for done, (material, both) in enumerate(zip(materials, pool.map(rows, materials), strict=True), 1):
            for name, row in zip(MEMORY_MEASURES, both, strict=True):
                tables[name][material] = row
            on_part(done, len(materials))
    return tables
