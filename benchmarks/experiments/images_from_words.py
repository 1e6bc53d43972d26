"""Images from words by texture_flow, in the protocol of `image_label_balance`, at several solver steps and guidances.

With few images a generator may copy them, so each generated image is compared with the nearest that was trained on, as
are real images that were not: those of another seed of the simulator.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.distance import cdist
from torch import Tensor

from tactogram.datasets import Store
from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.distances import ImageQuality
from tactogram.evaluation.pictures.figures import GeneratorRow, generated_figure
from tactogram.evaluation.pictures.networks import TrunkDistance
from tactogram.evaluation.report import save_figure
from tactogram.models.texture_flow.image_learner import ImageFlowLearner
from tactogram.signal import Image
from tactogram.training.checkpoint import load_state
from tactogram.training.labelled_images import as_floats, square
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram_benchmark.experiments.artifacts import cached_result, find_or_simulate, spread, trained_run
from tactogram_benchmark.experiments.image_cells import (
    DRAWS,
    TRIALS,
    RatedPlates,
    as_tensor,
    draws_of,
    figures_of,
    plates_of,
    rater_run,
    real_images,
)
from tactogram_benchmark.experiments.picture_cells import text_of

STEPS = (1, 4, 8, 16)
GUIDANCE = (1.0, 1.5, 2.0, 3.0)
UNSEEN_SEED = 1
"""Of the simulator, for real images that were not trained on."""
FRECHET = "efficientnet_lite0_frechet_distance"


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    images: str = "",
    unseen: str = "",
    plates: str = "",
    rater: str = "",
    trainings: int = 3,
    recipe: str = "image",
) -> dict[str, Any]:
    """Return the figures of each training, and those of the first at other steps and guidances; draw its images.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    images, unseen, plates : str
        Stores of rated images, of images that are not trained on, and of rated surfaces; default: simulated.
    rater : str
        Run of a rater of images; default: one is trained.
    trainings : int
        Seeds.
    recipe : str
        Recipe of texture_flow.
    """
    seen = find_or_simulate(folder / "tactile_images", "tactile_images", given=images, progress=progress)
    other = find_or_simulate(
        folder / "unseen_images", "tactile_images", given=unseen, seed=UNSEEN_SEED, progress=progress
    )
    felt = find_or_simulate(folder / "ultrasonic", "ultrasonic", given=plates, progress=progress)
    scorer, wanted = rater_run(folder, seen, rater, progress=progress), plates_of(felt)
    chosen, others = real_images(seen)
    quality, nearest = ImageQuality(chosen), NearestImage.of(all_images(seen))
    runs = [
        trained_run(
            "texture_flow", seen, folder / "runs" / str(seed),
            recipe=recipe, changes={"seed": seed}, split="all", progress=progress,
        )
        for seed in range(trainings)
    ]  # fmt: skip
    real = nearest(real_images(other)[0])
    loaded, rater_model = [load_run(place) for place in runs], load_run(scorer)

    def figures(run: LoadedRun, **changes: float) -> dict[str, Any]:
        made = draws_of(with_config(run, **changes) if changes else run, wanted)
        pixels = as_tensor([image for row in made for image in row])
        return figures_of(made, rater_model, wanted, quality) | {
            "nearest": nearest(pixels).compared_with(real)
        }

    def cached(name: str, run: LoadedRun, compute: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        facts = {"run_id": run.run.data["run_id"], "rater_id": rater_model.run.data["run_id"]}
        return cached_result(folder / "cells" / f"{name}.json", facts, compute)

    cells = [cached(run.run.name, run, partial(figures, run)) | {"spread": spread_of(run)} for run in loaded]
    settings = {
        f"{name} {value:g}": cells[0]
        if getattr(loaded[0].config, name) == value
        else cached(f"{name}-{value:g}", loaded[0], partial(figures, loaded[0], **{name: value}))
        for name, values in (("solver_steps", STEPS), ("guidance", GUIDANCE))
        for value in values
    }
    _draw(folder / "images.png", loaded[0], wanted, simulated=seen.simulated)
    summary = _summary(cells)
    result: dict[str, Any] = {
        "figures": ["images.png"],
        "trainings": trainings,
        "simulated": seen.simulated or felt.simulated,
        "images": {"name": seen.name, "sha256": seen.sha256, "simulated": seen.simulated},
        "plates": {"name": felt.name, "sha256": felt.sha256, "simulated": felt.simulated},
        "summary": summary,
        "runs": [
            {
                "run_id": cell["asked"]["run_id"],
                **{key: cell[key] for key in ("following", "spread", "quality", "nearest")},
            }
            for cell in cells
        ],
        "real": {
            "frechet": None if others is None else quality(others).get(FRECHET),
            "nearest": real.as_dict(),
            "nearest_in_words": _shown(
                figures_of(nearest_in_words(seen, wanted), rater_model, wanted, quality)
            ),
        },
        "missing": quality.missing,
        "settings": {name: _shown(found) for name, found in settings.items()},
    }
    lines = [f"{name:28}{text_of(found, digits=3)}" for name, found in summary.items()]
    lines += [
        f"{name:28}r {found['correlation']:.3f}, Fréchet {found['frechet']:.0f}"
        for name, found in result["settings"].items()
    ]
    return result | {"text": "\n".join([*lines, f"real: {result['real']}"])}


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of images to the nearest of others, float64, shape (image,)."""

    pixels: NDArray[np.float64]
    """Root mean square over pixels of -1 to 1."""
    features: NDArray[np.float64]
    """In the features of EfficientNet-Lite0."""

    def as_dict(self) -> dict[str, float]:
        """Return their means."""
        return {"pixels": float(self.pixels.mean()), "features": float(self.features.mean())}

    def compared_with(self, real: Distances) -> dict[str, float]:
        """Return the means, and the shares of images nearer than the nearest real one."""
        return self.as_dict() | {
            "nearer_in_pixels": float((self.pixels < real.pixels.min()).mean()),
            "nearer_in_features": float((self.features < real.features.min()).mean()),
        }


@dataclass(frozen=True, eq=False)
class NearestImage:
    """Images that others are compared with: pixels and features, shape (image, number)."""

    pixels: NDArray[np.float64]
    features: NDArray[np.float64]
    trunk: TrunkDistance

    @classmethod
    def of(cls, images: Tensor) -> NearestImage:
        """Return those of images, (image, 3, row, column), -1 to 1."""
        trunk = TrunkDistance()
        return cls(images.flatten(1).double().numpy(), trunk.features(images), trunk)

    def __call__(self, images: Tensor) -> Distances:
        """Return the distances of images to the nearest of these."""
        pixels, features = images.flatten(1).double().numpy(), self.trunk.features(images)
        return Distances(
            cdist(pixels, self.pixels).min(1) / np.sqrt(pixels.shape[1]),
            cdist(features, self.features).min(1),
        )


def nearest_in_words(images: Store, plates: RatedPlates, *, count: int = DRAWS) -> list[list[Image]]:
    """Return the images whose ratings are nearest to each plate's, 64 x 64, shape (plate, image)."""
    if images.ratings is None:
        raise ParameterError(f"{images.path}: has no ratings of images")
    keys = images.photographs_by_material
    shown = [square(images.photograph(held[0]), 64).transpose(1, 2, 0) for held in keys.values()]
    order = [images.ratings.words.index(word) for word in plates.words]
    rated = np.stack([images.ratings.rated(item).means[order] for item in keys])
    return [[Image(shown[place]) for place in row[:count]] for row in cdist(plates.means, rated).argsort(1)]


def _shown(found: dict[str, Any]) -> dict[str, Any]:
    return {"correlation": found["following"]["correlation"], "frechet": found["quality"].get(FRECHET)}


def spread_of(run: LoadedRun) -> dict[str, float]:
    """Return the spread of images by noise and by label."""
    return cast("ImageFlowLearner", run.model).image_spread().as_dict()


def all_images(store: Store) -> Tensor:
    """Return all images of a store in the form of `real_images`."""
    keys = [key for held in store.photographs_by_material.values() for key in held]
    return torch.from_numpy(as_floats(np.stack([square(store.photograph(key), 64) for key in keys])))


def with_config(loaded: LoadedRun, **changes: float) -> LoadedRun:
    """Return a run that generates with another configuration."""
    config = loaded.config.model_copy(update=changes)
    model = loaded.facts.build(config, loaded.any_kind, seed=loaded.recipe.seed)
    model.load_state(load_state(loaded.run.folder / "model.safetensors")[0])
    return replace(loaded, model=model)


def _summary(cells: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return mean and standard deviation over trainings."""
    places = {
        "correlation": ("following", "correlation"),
        "slope": ("following", "slope"),
        "error": ("following", "error"),
        "frechet": ("quality", FRECHET),
        "by_noise": ("spread", "noise_share"),
        "by_label": ("spread", "label_share"),
        **{f"nearest_{key}": ("nearest", key) for key in cells[0]["nearest"]},
    }
    return {
        name: spread([cell[part][key] for cell in cells])
        for name, (part, key) in places.items()
        if key in cells[0][part]
    }


def _draw(file: Path, loaded: LoadedRun, plates: RatedPlates, *, simulated: bool) -> None:
    made = draws_of(loaded, plates, draws=TRIALS)
    trials = [[row[trial] for row in made] for trial in range(TRIALS)]
    losses = {"loss": [(line["step"], line["loss"]) for line in loaded.run.metrics() if "loss" in line]}
    title = "texture_flow" + ", simulated images, surfaces and raters" * simulated
    save_figure(file, generated_figure([GeneratorRow("", trials, losses)], plates.names, title=title))
