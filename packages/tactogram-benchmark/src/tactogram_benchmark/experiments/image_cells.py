"""Parts shared by the experiments on Hatori et al. 2025: plates, image generators and a rater of images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tactogram.datasets import Split, Store
from tactogram.errors import ParameterError
from tactogram.evaluation import ImageQuality, ImageSpread, LabelFidelity, label_fidelity
from tactogram.signal import Image
from tactogram.training import as_floats, square
from tactogram.workflows import ProgressCallback, load_run, score
from tactogram_benchmark.experiments.artifacts import cached_result, trained_run

WEIGHTS = (1, 1000, 5000, 10000)
"""Sec. II-C."""
DRAWS = 8
"""Noises per label."""
REAL = 96
"""Real images for comparison: as many as 12 plates and `DRAWS` noises give."""

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


def rater_run(folder: Path, images: Store, given: str, *, progress: ProgressCallback) -> Path:
    """Return the run of a rater of images, trained on seven tenths of them and tested on the others."""
    if given:
        return Path(given)
    return trained_run("rater", images, folder / "runs" / "rater", recipe="quick", progress=progress)


def evaluate_images_of(
    folder: Path,
    run: Path,
    rater: Path,
    plates: RatedPlates,
    quality: ImageQuality,
) -> dict[str, Any]:
    """Return how closely a generator's images follow plates' scores, their variation, and their distance to real ones.

    Cached in ``cells/RUN.json``.
    """
    loaded, rater_model = load_run(run), load_run(rater)
    facts = {
        "run_id": loaded.run.data["run_id"],
        "rater_id": rater_model.run.data["run_id"],
        "plates": plates.means.round(6).tolist(),
    }

    def evaluated() -> dict[str, Any]:
        spread: ImageSpread | None = loaded.model.image_spread()
        if spread is None:
            raise ParameterError(f"{run}: {loaded.facts.name} does not measure the variation of its images")
        return {
            **figures_of(draws_of(loaded, plates), rater_model, plates, quality),
            "spread": spread.as_dict(),
            "collapse": spread.collapse,
            "simulated": loaded.simulated,
        }

    return cached_result(folder / "cells" / f"{run.name}.json", facts, evaluated)


def figures_of(
    made: Sequence[Sequence[Image]], rater: Any, plates: RatedPlates, quality: ImageQuality
) -> dict[str, Any]:
    """Return how closely images, shape (plate, draw), follow the scores of plates, and their distance to real ones."""
    said = np.array([[scores_of(rater, image, plates.words) for image in row] for row in made])
    return {
        "following": label_fidelity(plates.means, said).as_dict(),
        "said": said.round(4).tolist(),
        "quality": quality(as_tensor([image for row in made for image in row])),
    }


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


def scores_of(rater: Any, item: Any, words: Sequence[str]) -> Array:
    """Return the scores of an item predicted by a rater model, 0 to 1, shape (word,)."""
    said = score(rater, item)
    low, high = said["scale"]
    scores: Array = (np.array([said["scores"][word] for word in words]) - low) / (high - low)
    return scores


def real_images(images: Store, *, count: int = REAL) -> tuple[torch.Tensor, torch.Tensor | None]:
    """Return real images, evenly selected, and at most as many others, None if these are fewer than 2.

    In the generators' form, float32, (image, 3, 64, 64).
    """
    keys = [key for held in images.photographs_by_material.values() for key in held]

    def selected(places: NDArray[np.int_]) -> tuple[NDArray[np.int_], torch.Tensor]:
        some = places[np.linspace(0, len(places) - 1, min(count, len(places))).round().astype(int)]
        pixels = np.stack([square(images.photograph(keys[place]), 64) for place in some])
        return some, torch.from_numpy(as_floats(pixels))

    some, chosen = selected(np.arange(len(keys)))
    rest = np.setdiff1d(np.arange(len(keys)), some)
    return chosen, selected(rest)[1] if len(rest) > 1 else None


def as_tensor(made: Sequence[Image]) -> torch.Tensor:
    """Return generated images, float32, (image, 3, row, column), -1 to 1."""
    return torch.from_numpy(
        np.stack([image.pixels for image in made]).transpose(0, 3, 1, 2) / np.float32(127.5) - 1
    )


def of_real_images(images: Store, rater: Path) -> LabelFidelity | None:
    """Return how closely the rater follows the ratings of unseen real images: an upper bound for generated ones."""
    rater_model = load_run(rater)
    held = Split.load(rater_model.run.folder / "split.json").photographs
    unseen = {region.key for region in (*held.get("test", ()), *held.get("validation", ()))}
    item_of = {key: item for item, keys in images.photographs_by_material.items() for key in keys}
    rows = [(key, item_of[key]) for key in sorted(unseen) if key in item_of]
    if images.ratings is None or len(rows) < 3:
        return None
    words = images.ratings.words
    ratings = np.stack([images.ratings.rated(item).means for _, item in rows])
    said = np.stack([scores_of(rater_model, images.photograph(key), words) for key, _ in rows])
    return label_fidelity(ratings, said[:, None])
