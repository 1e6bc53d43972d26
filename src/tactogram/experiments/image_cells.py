"""Parts shared by the experiments on Hatori et al. 2025: stores, image generators of four weights, a rater of images.

Everything is made once in the experiment's folder and read again; a training goes on where it stopped.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tactogram.datasets import Split, Store
from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.image_quality import ImageQuality
from tactogram.evaluation.pictures.image_spread import ImageSpread
from tactogram.evaluation.ratings.label_following import LabelFidelity, label_fidelity
from tactogram.experiments.stores import find_or_simulate
from tactogram.model import SpreadReporter
from tactogram.models.tactile_image_cgan.images import as_floats, square
from tactogram.signal import Image
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.recognition.score import score
from tactogram.workflows.training.loaded_run import load_run
from tactogram.workflows.training.train import train

WEIGHTS = (1, 1000, 5000, 10000)
"""Sec. II-C."""
DRAWS = 8
"""Noises that each label is judged over."""
REAL = 96
"""Real images that generated ones are compared with: as many as 12 plates and `DRAWS` noises give."""

Array = NDArray[np.float64]


def store_of(folder: Path, set_name: str, given: str, *, progress: ProgressCallback) -> Store:
    """Return the store at ``given``, or a simulated set, made once in ``folder``."""
    return find_or_simulate(folder / set_name, set_name, given=given, progress=progress)


@dataclass(frozen=True, eq=False)
class RatedPlates:
    """Surfaces that were scored.

    Parameters
    ----------
    names : tuple of str
    words : tuple of str
    means : float64 array, shape (plate, word)
        Mean scores, 0 to 1.
    """

    names: tuple[str, ...]
    words: tuple[str, ...]
    means: Array


def plates_of(store: Store) -> RatedPlates:
    """Return the rated surfaces of a store: what its recordings with a material were scored."""
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
    """Return the folder of an image generator of one weight, trained on all images."""
    run = folder / "runs" / f"weight-{weight}-{seed}"
    train(
        "tactile_image_cgan",
        images.path,
        recipe=recipe,
        changes={"config.image_weight": float(weight), "seed": seed},
        split="all",
        out=run,
        resume=(run / "recipe.toml").exists(),
        progress=progress,
    )
    return run


def rater_run(folder: Path, images: Store, given: str, *, progress: ProgressCallback) -> Path:
    """Return the folder of a rater of images, trained on seven tenths of them; the rest says how far it errs."""
    if given:
        return Path(given)
    run = folder / "runs" / "rater"
    resume = (run / "recipe.toml").exists()
    train("rater", images.path, recipe="quick", out=run, resume=resume, progress=progress)
    return run


def evaluate_images_of(
    folder: Path,
    run: Path,
    rater: Path,
    plates: RatedPlates,
    quality: ImageQuality,
) -> dict[str, Any]:
    """Return how far a generator's images follow plates' scores, differ, and are like real ones.

    Kept in ``cells/RUN.json`` and read again where run, rater and plates are the same.
    """
    loaded, judging = load_run(run), load_run(rater)
    kept = folder / "cells" / f"{run.name}.json"
    asked_of = {
        "run_id": loaded.run.data["run_id"],
        "rater_id": judging.run.data["run_id"],
        "plates": plates.means.round(6).tolist(),
    }
    if kept.is_file():
        found: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
        if found["asked"] == asked_of:
            return found
    made = draws_of(loaded, plates)
    said = np.array(
        [[scores_of(judging, image, plates.words) for image in row] for row in made]
    )  # plate, draw, word
    if not isinstance(loaded.model, SpreadReporter):
        raise ParameterError(f"{run}: {loaded.facts.name} does not measure how its images differ")
    spread: ImageSpread = loaded.model.image_spread()
    result = label_fidelity(plates.means, said)
    flat = [image for row in made for image in row]
    found = {
        "asked": asked_of,
        "following": result.as_dict(),
        "said": said.round(4).tolist(),
        "spread": spread.as_dict(),
        "collapse": spread.collapse,
        "quality": quality(as_tensor(flat)),
        "missing": quality.missing,
        "simulated": loaded.simulated,
    }
    kept.parent.mkdir(parents=True, exist_ok=True)
    write_text(kept, json.dumps(found, indent=1) + "\n")
    return found


def draws_of(loaded: Any, plates: RatedPlates, *, draws: int = DRAWS) -> list[list[Image]]:
    """Return images of each plate's mean scores, from the same noises for all: shape (plate, draw)."""
    low, high = loaded.any_kind.scale
    asked = [
        {word: float(low + mean * (high - low)) for word, mean in zip(plates.words, row, strict=True)}
        for row in plates.means
    ]
    return [
        [loaded.generator.generate({"words": words}, seed=seed) for seed in range(draws)] for words in asked
    ]


def scores_of(judging: Any, given: Any, words: Sequence[str]) -> Array:
    """Return what a rater model says, 0 to 1, shape (word,)."""
    said = score(judging, given)
    low, high = said["scale"]
    scores: Array = (np.array([said["scores"][word] for word in words]) - low) / (high - low)
    return scores


def real_images(images: Store, *, count: int = REAL) -> torch.Tensor:
    """Return real images as the generators learned from them, float32, (image, 3, 64, 64), evenly taken."""
    keys = [key for held in images.photographs_by_material.values() for key in held]
    some = np.linspace(0, len(keys) - 1, min(count, len(keys))).round().astype(int)
    return torch.from_numpy(as_floats(np.stack([square(images.photograph(keys[k]), 64) for k in some])))


def as_tensor(made: Sequence[Image]) -> torch.Tensor:
    """Return generated images, float32, (image, 3, row, column), -1 to 1."""
    return torch.from_numpy(
        np.stack([image.pixels for image in made]).transpose(0, 3, 1, 2) / np.float32(127.5) - 1
    )


def of_real_images(images: Store, rater: Path) -> LabelFidelity | None:
    """Return how far the rater follows the ratings of real images that it did not see: what it can tell at best."""
    judging = load_run(rater)
    held = Split.load(judging.run.folder / "split.json").photographs
    unseen = {region.key for region in (*held.get("test", ()), *held.get("validation", ()))}
    item_of = {key: item for item, keys in images.photographs_by_material.items() for key in keys}
    rows = [(key, item_of[key]) for key in sorted(unseen) if key in item_of]
    if images.ratings is None or len(rows) < 3:
        return None
    words = images.ratings.words
    asked = np.stack([images.ratings.rated(item).means for _, item in rows])
    said = np.stack([scores_of(judging, images.photograph(key), words) for key, _ in rows])
    return label_fidelity(asked, said[:, None])
