"""Comparison of image generators: label fidelity, distance to real images, spread, losses, and two figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import Any

import numpy as np

from tactogram.datasets import Store
from tactogram.evaluation import (
    MEASURES,
    GeneratorRow,
    ImageQuality,
    TradeOff,
    generated_figure,
    save_figure,
    trade_off_figure,
)
from tactogram.workflows import load_run
from tactogram_benchmark.experiments.image_cells import (
    DRAWS,
    RatedPlates,
    draws_of,
    evaluate_images_of,
    of_real_images,
    plates_of,
    real_images,
)

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
        "images": {"name": images.name, "sha256": images.sha256, "simulated": images.simulated},
        "plates": {"name": plates.name, "sha256": plates.sha256, "simulated": plates.simulated},
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
    columns = [*COLUMNS, *((MEASURES[name][0], "quality", name) for name in names)]
    rows = [["", "n", *(head for head, _, _ in columns), ""]]
    for name, row in result["variants"].items():
        collapse = ", ".join(sorted({cell["collapse"] or "no collapse" for cell in row}))
        note = f"; {notes[name]}" if name in notes else ""
        cells = [_spread([cell[part][key] for cell in row]) for _, part, key in columns]
        rows.append([name, str(len(row)), *cells, collapse + note])
    left, *across = (max(map(len, column)) for column in list(zip(*rows, strict=True))[:-1])
    lines = [
        f"{title}; mean ± sd over trainings, losses over their last half; scores of 0 to 1 predicted by a rater model"
    ]
    for name, *cells, remark in rows:
        figures = "".join(f"{cell:>{width + 2}}" for cell, width in zip(cells, across, strict=True))
        lines.append(f"{name:{left}}{figures}  {remark}".rstrip())
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
