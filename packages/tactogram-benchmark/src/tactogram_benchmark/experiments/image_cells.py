"""Parts shared by the experiments on Hatori et al. 2025: rated plates, and image generators."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Store
from tactogram.errors import ParameterError
from tactogram.signal import Image
from tactogram.workflows import ProgressCallback
from tactogram_benchmark.experiments.artifacts import trained_run

WEIGHTS = (1, 1000, 5000, 10000)
"""Sec. II-C."""
DRAWS = 8
"""Noises per label."""

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RatedPlates:
    """Rated surfaces."""

    names: tuple[str, ...]
    words: tuple[str, ...]
    means: Array
    """Mean scores, 0 to 1, float64, shape (plate, word)."""


def plates_of(store: Store) -> RatedPlates:
    """Return the materials of a store that have ratings."""
    if store.ratings is None:
        raise ParameterError(f"{store.path}: has no ratings of surfaces")
    rated = set(store.ratings.items)
    names = tuple(sorted({info.material for info in store.index if info.material in rated and info.material}))
    if len(names) < 3:
        raise ParameterError(f"{store.path}: must hold at least 3 rated surfaces, got {len(names)}")
    means = np.stack([store.ratings.rated(name).means for name in names])
    return RatedPlates(names, store.ratings.words, means)


def image_run(
    folder: Path, images: Store, *, weight: int, seed: int, recipe: str, progress: ProgressCallback
) -> Path:
    """Return the run of an image generator of one weight, trained on all images."""
    changes = {"config.image_weight": float(weight), "seed": seed}
    run = folder / "runs" / f"weight-{weight}-{seed}"
    options: dict[str, Any] = {"recipe": recipe, "changes": changes, "split": "all"}
    return trained_run("tactile_image_cgan", images, run, **options, progress=progress)


def draws_of(loaded: Any, plates: RatedPlates, *, draws: int = DRAWS) -> list[list[Image]]:
    """Return images for each plate's mean scores, from the same noises for all: shape (plate, draw)."""
    low, high = loaded.any_kind.scale
    conditions = [
        {word: float(low + mean * (high - low)) for word, mean in zip(plates.words, row, strict=True)}
        for row in plates.means
    ]
    return [
        [loaded.generator.generate({"words": words}, seed=seed) for seed in range(draws)]
        for words in conditions
    ]
