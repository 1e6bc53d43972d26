"""Hatori et al. 2025, Figure 4: images of twelve plates from two noises and the losses, for four image weights.

Adds what the paper does not measure: whether images follow their labels according to a rater model, their variation
by noise and by label, their distance to real images, and the resulting trade-off between weights.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.evaluation.pictures.distances import MEASURES, ImageQuality
from tactogram.evaluation.pictures.image_figures import (
    GeneratorRow,
    TradeOff,
    generated_figure,
    trade_off_figure,
)
from tactogram.evaluation.report import save_figure
from tactogram.experiments.artifacts import find_or_simulate
from tactogram.experiments.image_cells import (
    DRAWS,
    WEIGHTS,
    RatedPlates,
    draws_of,
    evaluate_images_of,
    image_run,
    of_real_images,
    plates_of,
    rater_run,
    real_images,
)
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import load_run

TRIALS = 2
"""Noises in the figure. Fig. 4, "Images from two trials are shown"."""
LETTERS = "abcdefgh"
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
    folder, paper, progress
        See `tactogram.experiments`.
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
    wanted = plates_of(felt)
    scoring = rater_run(folder, seen, rater, progress=progress)
    recipe = recipe or ("paper" if paper else "quick")
    quality = ImageQuality(real_images(seen))
    cells: dict[int, list[dict[str, Any]]] = {}
    for weight in chosen:
        made = [
            image_run(folder, seen, weight=weight, seed=seed, recipe=recipe, progress=progress)
            for seed in range(trainings)
        ]
        cells[weight] = [evaluate_images_of(folder, each, scoring, wanted, quality) for each in made]
    best = of_real_images(seen, scoring)
    simulated = seen.simulated or felt.simulated
    said = "simulated images, surfaces and raters" if simulated else "recorded"
    figure, curve = folder / "figure4.png", folder / "trade_off.png"
    rows = [_row(folder, weight, wanted, letter) for letter, weight in zip(LETTERS, chosen, strict=False)]
    labels = [name.removeprefix("plate").lstrip("0") or name for name in wanted.names]
    title = f"Fig. 4, {recipe} recipe, {said}"
    save_figure(figure, generated_figure(rows, [f"ID{label}" for label in labels], title=title))
    measure = "fid" if "fid" in cells[chosen[0]][0]["quality"] else "efficientnet_lite0_frechet_distance"
    if all(measure in cell["quality"] for row in cells.values() for cell in row):
        drawn = trade_off_figure(
            [_trade(weight, row, measure) for weight, row in cells.items()],
            distance=MEASURES[measure][0],
            best=None if best is None else best.correlation,
            title=f"{said}; scores predicted by a rater model; {len(wanted.names)} plates, {DRAWS} noises each",
        )
        save_figure(curve, drawn)
    result: dict[str, Any] = {
        "figure": str(figure),
        "trade_off": str(curve) if curve.is_file() else None,
        "recipe": recipe,
        "trainings": trainings,
        "simulated": simulated,
        "images": {"name": seen.name, "sha256": seen.sha256, "simulated": seen.simulated},
        "plates": {"name": felt.name, "sha256": felt.sha256, "simulated": felt.simulated},
        "rater": str(scoring),
        "rater_on_unseen_images": None if best is None else best.as_dict(),
        "missing": quality.missing,
        "weights": {str(weight): row for weight, row in cells.items()},
        "losses": {str(weight): _losses_of(folder, weight) for weight in chosen},
    }
    return result | {"text": _text(result, said)}


def _weights(text: str) -> list[int]:
    """Return the weights in a text, ascending."""
    try:
        found = sorted({int(part) for part in str(text).split(",")})
    except ValueError:
        found = []
    if not found or found[0] < 1 or len(found) > len(LETTERS):
        raise ParameterError(
            f"weights must be 1 to {len(LETTERS)} whole numbers from 1, separated by commas, got {text!r}"
        )
    return found


def _row(folder: Path, weight: int, plates: RatedPlates, letter: str) -> GeneratorRow:
    loaded = load_run(folder / "runs" / f"weight-{weight}-0")
    made = draws_of(loaded, plates, draws=TRIALS)
    trials = [[row[trial] for row in made] for trial in range(TRIALS)]
    metrics = loaded.run.metrics()
    losses = {
        name: [(line["step"], line[name]) for line in metrics] for name in ("generator", "discriminator")
    }
    return GeneratorRow(f"({letter}) image weight {weight:,}", trials, losses)


def _losses_of(folder: Path, weight: int) -> dict[str, float]:
    """Return mean losses over the last half of a training, and the standard deviation of the discriminator's."""
    lines = load_run(folder / "runs" / f"weight-{weight}-0").run.metrics()
    late = lines[len(lines) // 2 :]
    discriminator = np.array([line["discriminator"] for line in late])
    return {
        "discriminator": float(discriminator.mean()),
        "discriminator_sd": float(discriminator.std()),
        "generator": float(np.mean([line["generator"] for line in late])),
        "correct": float(np.mean([line["correct"] for line in late])),
    }


def _trade(weight: int, row: Sequence[Mapping[str, Any]], measure: str) -> TradeOff:
    return TradeOff(
        weight,
        [cell["following"]["correlation"] for cell in row],
        [cell["quality"][measure] for cell in row],
        [cell["spread"]["noise_share"] for cell in row],
        [cell["spread"]["label_share"] for cell in row],
    )


def _text(result: Mapping[str, Any], said: str) -> str:
    names = list(next(iter(result["weights"].values()))[0]["quality"])
    head = ("weight", "follows r", "slope", "error", "of others", "by noise", "by label", "D loss", "sd")
    lines = [
        f"Fig. 4 on {said}, {result['recipe']} recipe, mean over {result['trainings']} training(s); scores 0..1 "
        "predicted by a rater model",
        "".join(f"{name:>11}" for name in head)
        + "".join(f"  {MEASURES[name][0]}" for name in names)
        + "  collapse; published",
    ]
    for weight in map(int, result["weights"]):
        row, losses = result["weights"][str(weight)], result["losses"][str(weight)]

        def mean(part: str, name: str, row: Sequence[Mapping[str, Any]] = row) -> float:
            return float(np.mean([cell[part][name] for cell in row]))

        collapse = ", ".join(sorted({cell["collapse"] or "none" for cell in row}))
        values = (
            mean("following", "correlation"),
            mean("following", "slope"),
            mean("following", "error"),
            mean("following", "error_of_others"),
            mean("spread", "noise_share"),
            mean("spread", "label_share"),
            losses["discriminator"],
            losses["discriminator_sd"],
        )
        lines.append(
            f"{weight:>11,}"
            + "".join(f"{value:>11.3f}" for value in values)
            + "".join(f"  {mean('quality', name):>{len(MEASURES[name][0])}.1f}" for name in names)
            + f"  {collapse}; {PUBLISHED.get(weight, 'not tested')}"
        )
    best = result["rater_on_unseen_images"]
    if best:
        lines.append(
            f"the rater model on unseen real images: r {best['correlation']:.2f}, "
            f"slope {best['slope']:.2f}, error {best['error']:.3f}, of others {best['error_of_others']:.3f}"
        )
    lines += [f"{name}: {why}" for name, why in result["missing"].items()]
    return "\n".join(lines)
