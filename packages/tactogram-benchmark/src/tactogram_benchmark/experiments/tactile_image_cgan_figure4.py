"""Hatori et al. 2025, Figure 4: images of twelve plates from two noises and the losses, for four image weights.

Adds what the paper does not measure: whether images follow their labels according to a rater model, their variation
by noise and by label, their distance to real images, and the resulting trade-off between weights.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.workflows import ProgressCallback
from tactogram_benchmark.experiments.artifacts import find_or_simulate
from tactogram_benchmark.experiments.image_cells import WEIGHTS, compare_generators, image_run, rater_run

MOST = 8
"""Weights in a figure."""
PUBLISHED = {
    1: "discriminator's loss near 0; images of one label alike, unlike real ones",
    1000: "losses oscillate; images like real ones",
    5000: "losses oscillate; images like real ones",
    10000: "losses oscillate; images like real ones, least control by the label",
}
"""Sec. III-A, in words; the paper gives no figures."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    images: str = "",
    plates: str = "",
    rater: str = "",
    trainings: int = 1,
    recipe: str = "",
    weights: str = ",".join(map(str, WEIGHTS)),
) -> dict[str, Any]:
    """Return the figures of each weight, and draw Fig. 4 and the trade-off.

    Parameters
    ----------
    images, plates : str
        Stores of rated images and of rated surfaces; default: simulated.
    rater : str
        Run of a rater of images; default: one is trained.
    trainings : int
        Seeds per weight.
    recipe : str
        Recipe of the generators; default: ``paper``, or ``quick`` for the bench.
    weights : str
        Whole numbers, separated by commas.
    """
    chosen = _weights(weights)
    seen = find_or_simulate(folder / "tactile_images", "tactile_images", given=images, progress=progress)
    felt = find_or_simulate(folder / "ultrasonic", "ultrasonic", given=plates, progress=progress)
    scoring = rater_run(folder, seen, rater, progress=progress)
    recipe = recipe or ("paper" if paper else "quick")
    runs = {
        f"weight {weight:,}": [
            image_run(folder, seen, weight=weight, seed=seed, recipe=recipe, progress=progress)
            for seed in range(trainings)
        ]
        for weight in chosen
    }
    compared = compare_generators(
        folder,
        runs,
        images=seen,
        plates=felt,
        rater=scoring,
        title=f"Fig. 4, {recipe} recipe",
        figure="figure4.png",
        notes={f"weight {weight:,}": PUBLISHED.get(weight, "not tested") for weight in chosen},
    )
    return {"recipe": recipe, **compared}


def _weights(text: str) -> list[int]:
    try:
        found = sorted({int(part) for part in str(text).split(",")})
    except ValueError:
        found = []
    if not found or found[0] < 1 or len(found) > MOST:
        raise ParameterError.must(
            "weights", f"be 1 to {MOST} whole numbers from 1, separated by commas", text
        )
    return found
