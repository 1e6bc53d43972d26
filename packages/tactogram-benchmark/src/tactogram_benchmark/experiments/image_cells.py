"""Parts shared by the experiments on Hatori et al. 2025: plates, image generators and a rater of images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
    TradeOff,
    generated_figure,
    label_fidelity,
    save_figure,
    trade_off_figure,
)
from tactogram.signal import Image
from tactogram.training import as_floats, square
from tactogram.workflows import ProgressCallback, load_run, score
from tactogram_benchmark.experiments.artifacts import cached_result, origin_of, trained_run

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


def compare_generators(
    folder: Path,
    runs: Mapping[str, Sequence[Path]],
    *,
    images: Store,
    plates: Store,
    rater: Path,
    title: str,
    figure: str,
    notes: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return the figures of each variant's trainings, and draw its images and the trade-off.

    Parameters
    ----------
    folder : path
        Of the figures, ``figure`` and ``trade_off.png``, and of cached results.
    runs : mapping of str to sequence of path
        Trainings of each variant of `tactile_image_cgan`.
    images, plates : Store
        Rated images, and the rated surfaces whose scores are the conditions.
    rater : path
        Run of a rater of images.
    title, figure : str
        What is compared, and the file name of the figure of images.
    notes : mapping of str to str, optional
        Last column of the table, by variant.
    """
    wanted = plates_of(plates)
    chosen, others = real_images(images)
    quality = ImageQuality(chosen)
    cells = {
        name: [
            evaluate_images_of(folder, run, rater, wanted, quality) | {"losses": _losses_of(run)}
            for run in trained
        ]
        for name, trained in runs.items()
    }
    best = of_real_images(images, rater)
    simulated = images.simulated or plates.simulated
    said = "simulated images, surfaces and raters" if simulated else "recorded"
    rows = [
        _generator_row(trained[0], f"({letter}) {name}", wanted)
        for letter, (name, trained) in zip(ascii_lowercase, runs.items(), strict=False)
    ]
    labels = [f"ID{name.removeprefix('plate').lstrip('0') or name}" for name in wanted.names]
    save_figure(folder / figure, generated_figure(rows, labels, title=f"{title}, {said}"))
    measure = "fid" if "fid" not in quality.missing else "efficientnet_lite0_frechet_distance"
    if measure not in quality.missing:
        drawn = trade_off_figure(
            [_trade_off(name, row, measure) for name, row in cells.items()],
            distance=MEASURES[measure][0],
            best=None if best is None else best.correlation,
            title=f"{said}; scores predicted by a rater model; {len(wanted.names)} plates, {DRAWS} noises each",
        )
        save_figure(folder / "trade_off.png", drawn)
    result: dict[str, Any] = {
        "figures": [figure] if measure in quality.missing else [figure, "trade_off.png"],
        "trainings": {name: len(row) for name, row in cells.items()},
        "simulated": simulated,
        "images": origin_of(images),
        "plates": origin_of(plates),
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
    return result | {"text": _text(result, f"{title}; {said}", notes or {})}


def _generator_row(run: Path, title: str, plates: RatedPlates) -> GeneratorRow:
    loaded = load_run(run)
    made = draws_of(loaded, plates, draws=TRIALS)
    trials = [[row[trial] for row in made] for trial in range(TRIALS)]
    metrics = loaded.run.metrics()
    losses = {
        name: [(line["step"], line[name]) for line in metrics] for name in ("generator", "discriminator")
    }
    return GeneratorRow(title, trials, losses)


def _losses_of(run: Path) -> dict[str, float]:
    """Return mean losses over the last half of a training, and the standard deviation of the discriminator's."""
    lines = load_run(run).run.metrics()
    late = lines[len(lines) // 2 :]
    return {
        "discriminator": float(np.mean([line["discriminator"] for line in late])),
        "discriminator_sd": float(np.std([line["discriminator"] for line in late])),
        "generator": float(np.mean([line["generator"] for line in late])),
        "correct": float(np.mean([line["correct"] for line in late])),
    }


def _trade_off(name: str, cells: Sequence[Mapping[str, Any]], measure: str) -> TradeOff:
    return TradeOff(
        name,
        [cell["following"]["correlation"] for cell in cells],
        [cell["quality"][measure] for cell in cells],
        [cell["spread"]["noise_share"] for cell in cells],
        [cell["spread"]["label_share"] for cell in cells],
    )


def _spread(values: Sequence[float]) -> str:
    """Return the mean, and the standard deviation where there is more than one."""
    return f"{np.mean(values):.3g}" + (f" ± {np.std(values, ddof=1):.2g}" if len(values) > 1 else "")


def _text(result: Mapping[str, Any], title: str, notes: Mapping[str, str]) -> str:
    names = [name for name in ("fid", "efficientnet_lite0_frechet_distance") if name not in result["missing"]]
    heads = [*COLUMNS, *((MEASURES[name][0], "quality", name) for name in names)]
    table = [["", "n", *(head for head, _, _ in heads), ""]]
    for name, row in result["variants"].items():
        collapse = ", ".join(sorted({cell["collapse"] or "no collapse" for cell in row}))
        note = f"; {notes[name]}" if name in notes else ""
        cells = [_spread([cell[part][key] for cell in row]) for _, part, key in heads]
        table.append([name, str(len(row)), *cells, collapse + note])
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
