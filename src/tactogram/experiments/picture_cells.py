"""Cells of the tables of Neshov et al. 2026: one training each, finished ones read again, and how they are compared."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean, stdev
from typing import Any

from scipy.stats import ttest_rel

from tactogram.datasets import Store
from tactogram.experiments.stores import find_or_simulate
from tactogram.recipe import Preparation
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.evaluation.pictures import evaluate_pictures
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.train import train

MEASURES = (
    "lpips",
    "fid",
    "efficientnet_lite0_distance",
    "efficientnet_lite0_frechet_distance",
    "log_spectral_distance_db",
    "level_difference_db",
    "l1",
)
"""What is shown of a cell, lower is better in all; those whose networks are not at hand are left out."""
SIMULATED = "stroking9"
"""What is simulated where no data is given."""
JUDGED = 128
"""Pairs of the test part of each cell."""
PHOTOGRAPHS = 9
"""Of each simulated surface: non-overlapping places, of 224 x 224 pixels."""
LARGE_PHOTOGRAPHS = 4
"""Of each simulated surface, of 336 x 336 pixels; those of LMT-108 are of 320 x 480 (Sec. 4.1)."""


def data_of(folder: Path, data: str, *, paper: bool, progress: ProgressCallback) -> Store:
    """Return the store at ``data``, or simulated surfaces, made once.

    Those for ``paper`` have the rate of LMT-108, since a published picture is 32,640 samples long: 3.3 s at 10 kHz, and
    the surfaces are stroked for 4 s. Their photographs are fewer and larger, since the published crop is 256 pixels.
    """
    name, options = "data", dict[str, Any](photographs=PHOTOGRAPHS)
    if paper:
        name, options = "data-paper", {"photographs": LARGE_PHOTOGRAPHS, "rate": 10_000.0}
    return find_or_simulate(folder / name, SIMULATED, given=data, progress=progress, **options)


def axis_of(store: Store) -> dict[str, Any]:
    """Return what takes one axis of recordings that have several: z, or the last (Sec. 4.1)."""
    name = Preparation().stream_of(tuple(store.streams))
    axes = store.streams[name].axes
    if len(axes) < 2:
        return {}
    return {"prepare.axes": ["z" if "z" in axes else axes[-1]]}


def cell(
    folder: Path,
    store: Store,
    name: str,
    *,
    model: str,
    recipe: str,
    changes: Mapping[str, Any],
    seed: int,
    progress: ProgressCallback,
) -> dict[str, Any]:
    """Return the figures of one training, from ``cells/NAME-SEED.json`` where it is finished.

    The seed decides weights, crops and the split, so cells of one seed have one split: they are paired.

    Returns
    -------
    dict
        ``validation`` (what the weights were chosen by, not on the test part), ``values`` (`MEASURES`, test part),
        ``missing`` (why a measure is not there), ``pictures`` (how many).
    """
    kept = folder / "cells" / f"{name}-{seed}.json"
    changes = {**axis_of(store), **changes}
    facts = {
        "model": model,
        "recipe": recipe,
        "changes": changes,
        "seed": seed,
        "data_sha256": store.sha256,
    }
    if kept.is_file():
        found: dict[str, Any] = json.loads(kept.read_text(encoding="utf-8"))
        if found["asked"] == facts:
            return found
    run = run_of(folder, name, seed)
    trained = train(
        model,
        store.path,
        recipe=recipe,
        changes=changes | {"seed": seed},
        out=run,
        resume=(run / "recipe.toml").exists(),
        progress=progress,
    )
    found = {"asked": facts, "validation": trained.read_json("model.json").get("validation", {})}
    found |= evaluate_pictures(run, most=JUDGED, progress=progress)
    kept.parent.mkdir(parents=True, exist_ok=True)
    write_text(kept, json.dumps(found, indent=1) + "\n")
    return found


def run_of(folder: Path, name: str, seed: int) -> Path:
    """Return where the run of a cell is."""
    return folder / "runs" / f"{name}-{seed}"


def shown(cells: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the measures that every cell has."""
    return [name for name in MEASURES if all(name in found["values"] for found in cells)]


def spread(values: Sequence[float]) -> dict[str, Any]:
    """Return mean, standard deviation (None of one) and the values."""
    return {
        "mean": mean(values),
        "sd": stdev(values) if len(values) > 1 else None,
        "values": list(values),
    }


def against(proposed: Sequence[float], other: Sequence[float]) -> float | None:
    """Return p of a two-sided paired t-test (Sec. 4.3), None below three pairs or where nothing differs."""
    if len(proposed) < 3 or all(a == b for a, b in zip(proposed, other, strict=True)):
        return None
    return float(ttest_rel(proposed, other).pvalue)


def text_of(found: Mapping[str, Any], *, digits: int = 4) -> str:
    """Return mean ± sd as the paper prints it."""
    sd = "" if found["sd"] is None else f" ± {found['sd']:.{digits}f}"
    return f"{found['mean']:.{digits}f}{sd}"
