"""Cells of the tables of Neshov et al. 2026: one training each, its figures, and their comparison."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean, stdev
from typing import Any

from scipy.stats import ttest_rel

from tactogram.datasets import Store
from tactogram.experiments.artifacts import cached_result, find_or_simulate
from tactogram.recipe import Preparation
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
"""Measures of a cell; lower is better. Those whose networks are not available are left out."""
SIMULATED = "stroking9"
EVALUATED = 128
"""Pairs of the test part of each cell."""
PHOTOGRAPHS = 9
"""Per simulated surface, without overlap, of 224 x 224 pixels."""
LARGE_PHOTOGRAPHS = 4
"""Per simulated surface, of 336 x 336 pixels; those of LMT-108 have 320 x 480 (Sec. 4.1)."""


def data_of(folder: Path, data: str, *, paper: bool, progress: ProgressCallback) -> Store:
    """Return the store at ``data``, or simulated surfaces.

    For ``paper`` they have the rate of LMT-108, because a published picture is 32,640 samples long (3.3 s at 10 kHz;
    strokes last 4 s), and fewer, larger photographs, because the published crop is 256 pixels.
    """
    name, options = "data", dict[str, Any](photographs=PHOTOGRAPHS)
    if paper:
        name, options = "data-paper", {"photographs": LARGE_PHOTOGRAPHS, "rate": 10_000.0}
    return find_or_simulate(folder / name, SIMULATED, given=data, progress=progress, **options)


def axis_of(store: Store) -> dict[str, Any]:
    """Return the change of the recipe that selects one of several axes: z, or the last (Sec. 4.1)."""
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
    """Return the figures of one training, cached in ``cells/NAME-SEED.json``.

    The seed determines weights, crops and split, so cells of one seed share a split and are paired.

    Returns
    -------
    dict
        ``validation`` (used to select weights, not on the test part), ``values`` (`MEASURES`, test part),
        ``missing`` (reasons by measure), ``pictures`` (their number).
    """
    changes = {**axis_of(store), **changes}
    facts = {
        "model": model,
        "recipe": recipe,
        "changes": changes,
        "seed": seed,
        "data_sha256": store.sha256,
    }

    def evaluated() -> dict[str, Any]:
        run = run_of(folder, name, seed)
        resume = (run / "recipe.toml").exists()
        seeded = changes | {"seed": seed}
        trained = train(
            model, store.path, recipe=recipe, changes=seeded, out=run, resume=resume, progress=progress
        )
        validation = trained.read_json("model.json").get("validation", {})
        return {"validation": validation, **evaluate_pictures(run, most=EVALUATED, progress=progress)}

    return cached_result(folder / "cells" / f"{name}-{seed}.json", facts, evaluated)


def run_of(folder: Path, name: str, seed: int) -> Path:
    """Return the folder of a cell's run."""
    return folder / "runs" / f"{name}-{seed}"


def shown(cells: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the measures available in every cell."""
    return [name for name in MEASURES if all(name in found["values"] for found in cells)]


def spread(values: Sequence[float]) -> dict[str, Any]:
    """Return mean, standard deviation (None for one value) and the values."""
    return {
        "mean": mean(values),
        "sd": stdev(values) if len(values) > 1 else None,
        "values": list(values),
    }


def against(proposed: Sequence[float], other: Sequence[float]) -> float | None:
    """Return p of a two-sided paired t-test (Sec. 4.3); None for fewer than three pairs or equal values."""
    if len(proposed) < 3 or all(a == b for a, b in zip(proposed, other, strict=True)):
        return None
    return float(ttest_rel(proposed, other).pvalue)


def text_of(found: Mapping[str, Any], *, digits: int = 4) -> str:
    """Return mean ± sd in the paper's format."""
    sd = "" if found["sd"] is None else f" ± {found['sd']:.{digits}f}"
    return f"{found['mean']:.{digits}f}{sd}"
