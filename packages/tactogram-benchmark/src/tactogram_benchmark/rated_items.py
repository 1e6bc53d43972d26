"""Rated items of a task: examples, names and mean scores."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings, Segment
from tactogram.workflows import RatingData
from tactogram_benchmark.data import OpenTask


def ratings_of(opened: OpenTask) -> Ratings:
    """Return the ratings of a task's store; a `ParameterError` if it has none."""
    return RatingData(opened.store, "ratings").ratings


def rated_surfaces(opened: OpenTask) -> tuple[Segment, ...]:
    """Return recordings of rated surfaces beside the rated signals of a task, from which some models learn, too."""
    split, ratings = opened.split, opened.store.ratings
    parts = {segment.id for part in split.parts.values() for segment in part}
    infos = opened.store.index
    if ratings is None or any(info.material is not None for info in infos if info.id in parts):
        return ()
    return tuple(Segment(info.id) for info in infos if info.material in ratings.items)


def rated_examples(opened: OpenTask, part: str) -> Sequence[Any]:
    """Return the rated examples of a part: of `Example`, or of `ImageExample` in a store of images."""
    return RatingData(opened.store, "ratings").examples(opened.split, part, opened.task.prepare)


def items_of(examples: Sequence[Any]) -> list[str]:
    """Return the names of the rated items of examples, sorted."""
    return sorted({str(example.item) for example in examples})


def mean_scores(opened: OpenTask, items: Sequence[str]) -> NDArray[np.float64]:
    """Return the mean scores of items on the scale of the ratings, float64, shape (item, word)."""
    ratings = ratings_of(opened)
    rows: NDArray[np.float64] = np.stack(
        [ratings.scale.from_unit(ratings.rated(item).means) for item in items]
    )
    return rows
