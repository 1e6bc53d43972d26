"""Hatori et al. 2025, Figure 4: images of twelve plates from two noises and the losses, for four image weights.

Adds what the paper does not measure: whether images follow their labels according to a rater model, their variation
by noise and by label, their distance to real images, and the resulting trade-off between weights.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tactogram.cli.printing import columns
from tactogram.datasets import Split, Store
from tactogram.errors import ParameterError
from tactogram.evaluation import (
    MEASURES,
    GeneratorRow,
    ImageQuality,
    ImageSpread,
    LabelFidelity,
    generated_figure,
    label_fidelity,
    save_figure,
)
from tactogram.signal import Image
from tactogram.training import as_floats, square
from tactogram.workflows import ProgressCallback, load_run, score
from tactogram_benchmark.experiments.artifacts import cached_result, find_or_simulate, origin_of, trained_run
from tactogram_benchmark.experiments.image_cells import (
    DRAWS,
    WEIGHTS,
    Array,
    RatedPlates,
    draws_of,
    image_run,
    plates_of,
)
from tactogram_benchmark.experiments.trade_off import TradeOff, trade_off_figure

MOST = 8
"""Weights in a figure."""
PUBLISHED = {
    1: "discriminator's loss near 0; images of one label alike, unlike real ones",
    1000: "losses oscillate; images like real ones",
    5000: "losses oscillate; images like real ones",
    10000: "losses oscillate; images like real ones, least control by the label",
}
"""Sec. III-A, in words; the paper gives no figures."""
REAL = 96
"""Real images for comparison: as many as 12 plates and `DRAWS` noises give."""
TRIALS = 2
"""Noises in the figure. Hatori et al. 2025, Fig. 4, "Images from two trials are shown"."""
COLUMNS = (
    ("follows r", "following", "correlation"),
    ("slope", "following", "slope"),
    ("error", "following", "error"),
    ("of others", "following", "error_of_others"),
    ("by noise", "spread", "noise_share"),
    ("by label", "spread", "label_share"),
    ("D loss", "losses", "discriminator"),
    ("its sd", "losses", "discriminator_sd"),
)
"""Title and place of the figures in a cell."""
REPORTED = ("following", "spread", "collapse", "quality", "losses")
LOSSES = ("discriminator", "generator", "correct")


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
    plate_store = find_or_simulate(folder / "ultrasonic", "ultrasonic", given=plates, progress=progress)
    scoring = Path(rater) if rater else folder / "runs" / "rater"
    if not rater:  # on seven tenths of the images, tested on the others
        trained_run("rater", seen, scoring, recipe="quick", progress=progress)
    recipe = recipe or ("paper" if paper else "quick")
    runs = {
        weight: [
            image_run(folder, seen, weight=weight, seed=seed, recipe=recipe, progress=progress)
            for seed in range(trainings)
        ]
        for weight in chosen
    }
    rated_plates = plates_of(plate_store)
    real, others = real_images(seen)
    quality = ImageQuality(real)
    cells = {
        f"weight {weight:,}": [_cell(folder, run, scoring, rated_plates, quality) for run in trained]
        for weight, trained in runs.items()
    }
    best = of_real_images(seen, scoring)
    simulated = seen.simulated or plate_store.simulated
    said = "simulated images, surfaces and raters" if simulated else "recorded"
    rows = [
        _generator_row(trained[0], f"({letter}) weight {weight:,}", rated_plates)
        for letter, (weight, trained) in zip(ascii_lowercase, runs.items(), strict=False)
    ]
    labels = [f"ID{name.removeprefix('plate').lstrip('0') or name}" for name in rated_plates.names]
    title = f"Fig. 4, {recipe} recipe"
    figures = ["figure4.png"]
    save_figure(folder / figures[0], generated_figure(rows, labels, title=f"{title}, {said}"))
    measure = "fid" if "fid" not in quality.missing else "efficientnet_lite0_frechet_distance"
    if measure not in quality.missing:
        figures.append("trade_off.png")
        drawn = trade_off_figure(
            [
                TradeOff(
                    name,
                    [cell["following"]["correlation"] for cell in row],
                    [cell["quality"][measure] for cell in row],
                    [cell["spread"]["noise_share"] for cell in row],
                    [cell["spread"]["label_share"] for cell in row],
                )
                for name, row in cells.items()
            ],
            distance=MEASURES[measure][0],
            best=None if best is None else best.correlation,
            title=f"{said}; scores predicted by a rater model; {len(rated_plates.names)} plates, {DRAWS} noises each",
        )
        save_figure(folder / figures[1], drawn)
    result: dict[str, Any] = {
        "recipe": recipe,
        "figures": figures,
        "trainings": {name: len(row) for name, row in cells.items()},
        "simulated": simulated,
        "images": origin_of(seen),
        "plates": origin_of(plate_store),
        "rater_on_unseen_images": None if best is None else best.as_dict(),
        "quality_of_other_real_images": None if others is None else quality(others),
        "missing": quality.missing,
        "variants": {
            name: [
                {"run_id": cell["asked"]["run_id"], **{key: cell[key] for key in REPORTED}} for cell in row
            ]
            for name, row in cells.items()
        },
    }
    notes = {f"weight {weight:,}": PUBLISHED.get(weight, "not tested") for weight in chosen}
    return result | {"text": _text(result, f"{title}; {said}", notes)}


def _weights(text: str) -> list[int]:
    try:
        numbers = sorted({int(part) for part in str(text).split(",")})
    except ValueError:
        numbers = []
    if not numbers or numbers[0] < 1 or len(numbers) > MOST:
        raise ParameterError.must(
            "weights", f"be 1 to {MOST} whole numbers from 1, separated by commas", text
        )
    return numbers


def _cell(folder: Path, run: Path, rater: Path, plates: RatedPlates, quality: ImageQuality) -> dict[str, Any]:
    """Return how closely a generator's images follow plates' scores, their variation, and their distance to real ones.

    Cached in ``cells/RUN.json``, with the losses of the training beside.
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
        images = draws_of(loaded, plates)
        said = np.array([[scores_of(rater_model, image, plates.words) for image in row] for row in images])
        return {
            "following": label_fidelity(plates.means, said).as_dict(),
            "said": said.round(4).tolist(),
            "quality": quality(as_tensor([image for row in images for image in row])),
            "spread": spread.as_dict(),
            "collapse": spread.collapse,
            "simulated": loaded.simulated,
        }

    cell = cached_result(folder / "cells" / f"{run.name}.json", facts, evaluated)
    return cell | {"losses": _losses(loaded.run.metrics())}


def _losses(lines: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return mean losses over the last half of a training, and the standard deviation of the discriminator's."""
    late = {name: [line[name] for line in lines[len(lines) // 2 :]] for name in LOSSES}
    return {name: float(np.mean(values)) for name, values in late.items()} | {
        "discriminator_sd": float(np.std(late["discriminator"]))
    }


def scores_of(rater: Any, item: Any, words: Sequence[str]) -> Array:
    """Return the scores of an item predicted by a rater model, 0 to 1, shape (word,)."""
    said = score(rater, item)
    low, high = said["scale"]
    scores: Array = (np.array([said["scores"][word] for word in words]) - low) / (high - low)
    return scores


def real_images(images: Store) -> tuple[torch.Tensor, torch.Tensor | None]:
    """Return real images, evenly selected, and at most as many others, None if these are fewer than 2.

    In the generators' form, float32, (image, 3, 64, 64).
    """
    keys = [key for held in images.photographs_by_material.values() for key in held]

    def selected(places: NDArray[np.int_]) -> tuple[NDArray[np.int_], torch.Tensor]:
        some = places[np.linspace(0, len(places) - 1, min(REAL, len(places))).round().astype(int)]
        pixels = np.stack([square(images.photograph(keys[row]), 64) for row in some])
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


def _generator_row(run: Path, title: str, plates: RatedPlates) -> GeneratorRow:
    loaded = load_run(run)
    images = draws_of(loaded, plates, draws=TRIALS)
    trials = [[row[trial] for row in images] for trial in range(TRIALS)]
    metrics = loaded.run.metrics()
    losses = {
        name: [(line["step"], line[name]) for line in metrics] for name in ("generator", "discriminator")
    }
    return GeneratorRow(title, trials, losses)


def _spread(values: Sequence[float]) -> str:
    """Return the mean, and the standard deviation where there is more than one."""
    return f"{np.mean(values):.3g}" + (f" ± {np.std(values, ddof=1):.2g}" if len(values) > 1 else "")


def _text(result: Mapping[str, Any], title: str, notes: Mapping[str, str]) -> str:
    names = [name for name in ("fid", "efficientnet_lite0_frechet_distance") if name not in result["missing"]]
    heads = [*COLUMNS, *((MEASURES[name][0], "quality", name) for name in names)]
    table = [["", "n", *(head for head, _, _ in heads), ""]]
    for name, row in result["variants"].items():
        collapse = ", ".join(sorted({cell["collapse"] or "no collapse" for cell in row}))
        cells = [_spread([cell[part][key] for cell in row]) for _, part, key in heads]
        table.append([name, str(len(row)), *cells, f"{collapse}; {notes[name]}"])
    lines = [
        f"{title}; mean ± sd over trainings, losses over their last half; scores of 0 to 1 predicted by a rater model",
        columns(table),
    ]
    if best := result["rater_on_unseen_images"]:
        lines.append(
            f"the rater model on unseen real images: r {best['correlation']:.2f}, "
            f"slope {best['slope']:.2f}, error {best['error']:.3f}, of others {best['error_of_others']:.3f}"
        )
    if floor := result["quality_of_other_real_images"]:
        lines.append(
            "other real images: "
            + ", ".join(f"{MEASURES[name][0]} {value:.0f}" for name, value in floor.items())
        )
    lines += [f"{name}: {why}" for name, why in result["missing"].items()]
    return "\n".join(lines)
