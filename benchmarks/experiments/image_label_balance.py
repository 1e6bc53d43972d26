"""Balance of image and label in tactile_image_cgan: weights, projection, regression and a normalised branch.

Hatori et al. 2025, Sec. III-A, call this balance crucial and change one weight. Each discriminator here is trained with
random scores of generated images, as published, and with those of the real images (``rated``), since random scores
alone may reveal a generated image: ``scores_alone`` is how often a linear classifier recognises them.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import cross_val_score

from tactogram.datasets import Store
from tactogram.errors import ParameterError
from tactogram.training.seeds import child_rng
from tactogram.workflows.progress import ProgressCallback
from tactogram_benchmark.experiments.artifacts import find_or_simulate, trained_run
from tactogram_benchmark.experiments.image_cells import compare_generators, rater_run

DISCRIMINATORS: dict[str, dict[str, Any]] = {
    "weight 1": {"image_weight": 1.0},
    "weight 5,000": {},
    "normalised": {"image_weight": 1.0, "label_input": "normalised"},
    "projection": {"image_weight": 1.0, "label_input": "projection"},
    "regression": {"image_weight": 1.0, "label_input": "none", "regression_weight": 1.0},
}
"""Changes of the configuration."""
VARIANTS = {
    name + suffix: {**changes, **more}
    for suffix, more in (("", {}), (", rated", {"fake_scores": "rated"}))
    for name, changes in DISCRIMINATORS.items()
}

FOLDS = 10
"""Of the classifier of scores."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    images: str = "",
    plates: str = "",
    rater: str = "",
    trainings: int = 0,
    variants: str = "",
) -> dict[str, Any]:
    """Return the figures of each variant, and draw its images and the trade-off.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` has the published width and three trainings, else a quarter and one.
    images, plates : str
        Stores of rated images and of rated surfaces; default: simulated.
    rater : str
        Run of a rater of images; default: one is trained.
    trainings : int
        Seeds per variant.
    variants : str
        Names, separated by semicolons; default: all.
    """
    chosen = [name.strip() for name in variants.split(";")] if variants else list(VARIANTS)
    if unknown := set(chosen) - VARIANTS.keys():
        raise ParameterError(f"variants must be of {'; '.join(VARIANTS)}, got {'; '.join(sorted(unknown))}")
    seen = find_or_simulate(folder / "tactile_images", "tactile_images", given=images, progress=progress)
    felt = find_or_simulate(folder / "ultrasonic", "ultrasonic", given=plates, progress=progress)
    recipe = "paper" if paper else "quick"

    def trained(name: str, seed: int) -> Path:
        changes = {f"config.{key}": value for key, value in VARIANTS[name].items()}
        place = folder / "runs" / f"{name.replace(',', '').replace(' ', '_')}-{seed}"
        options: dict[str, Any] = {"recipe": recipe, "changes": {**changes, "seed": seed}, "split": "all"}
        return trained_run("tactile_image_cgan", seen, place, **options, progress=progress)

    seeds = range(trainings or (3 if paper else 1))
    compared = compare_generators(
        folder,
        {name: [trained(name, seed) for seed in seeds] for name in chosen},
        images=seen,
        plates=felt,
        rater=rater_run(folder, seen, rater, progress=progress),
        title=f"Balance of image and label, {recipe} recipe",
        figure="images.png",
    )
    alone = _scores_alone(seen)
    compared["text"] += f"\nrandom scores recognised without any image: {100 * alone:.1f} %"
    return {"recipe": recipe, "scores_alone": alone, **compared}


def _scores_alone(images: Store) -> float:
    """Return the share of scores that a linear classifier recognises as random or of real images, cross-validated."""
    if images.ratings is None:
        raise ParameterError(f"{images.path}: has no ratings of images")
    rated = np.stack([images.ratings.rated(item).means for item in images.photographs_by_material])
    drawn = child_rng(0, "uniform scores").random(rated.shape)
    answers = np.repeat([0, 1], len(rated))
    return float(
        cross_val_score(LogisticRegression(), np.concatenate((drawn, rated)), answers, cv=FOLDS).mean()
    )
