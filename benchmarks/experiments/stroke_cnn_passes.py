"""Accuracy of `stroke_cnn` trained on few recordings, with and without the recipe `quick`'s limit on passes over them.

`quick` was chosen on hundreds of recordings; of one for each material its updates are hundreds of passes. By default on
simulated strokes; `data` is a store of others.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import mean, stdev
from typing import Any

import numpy as np

from tactogram.datasets import Store
from tactogram.datasets.examples import Examples, signal_kind
from tactogram.datasets.splits.split import Segment
from tactogram.experiments.artifacts import cached_result, find_or_simulate, kind_of
from tactogram.models import find
from tactogram.models.stroke_cnn.config import Config
from tactogram.models.stroke_cnn.learner import build
from tactogram.recipe import Recipe
from tactogram.training.device import make_fabric
from tactogram.training.loop import fit
from tactogram.workflows.progress import ProgressCallback

ARMS: dict[str, dict[str, Any]] = {"unlimited": {"epochs": 1_000_000}, "quick": {}}
FIGURES = ("window_accuracy", "recording_accuracy", "cpu_seconds", "updates")


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    band: Sequence[float] = (),
    materials: int = 9,
    tested: int = 10,
    seeds: int = 3,
) -> dict[str, Any]:
    """Return the accuracies, the updates and the processor time of both, per seed, with their differences.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    data : str
        Store; default: simulated.
    band : pair of float
        Pass band, Hz; default: all.
    materials, tested : int
        Materials drawn for each seed; one recording of each is trained on, and at most ``tested`` others are judged.
    seeds : int
        Seeds of the drawing and the training.
    """
    store = find_or_simulate(folder / "data", "stroking9", given=data, per_class=20, progress=progress)
    rows = []
    for seed in range(seeds):
        row: dict[str, Any] = {"seed": seed}
        for arm, config in ARMS.items():
            progress(f"seed {seed}", seed + 1, seeds, arm)
            changes = {"seed": seed} | ({"prepare.band": list(band)} if band else {})
            changes |= {f"config.{name}": value for name, value in config.items()}
            measure = partial(_measured, store, changes, materials, tested)
            row[arm] = cached_result(folder / f"{arm}-{seed}.json", changes, measure)
        rows.append(row)
    figures = {
        figure: {arm: _spread([row[arm][figure] for row in rows]) for arm in ARMS}
        | {"difference": _spread([row["quick"][figure] - row["unlimited"][figure] for row in rows])}
        for figure in FIGURES
    }
    lines = [
        f"{figure:20}" + "".join(f"{name} {v['mean']:.3f} ± {v['sd']:.3f}   " for name, v in found.items())
        for figure, found in figures.items()
    ]
    return {
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "rows": rows,
        **figures,
        "text": "\n".join(
            [f"{kind_of(store)}, {seeds} seeds, one recording of each of {materials} materials", *lines]
        ),
    }


def _measured(store: Store, changes: dict[str, Any], materials: int, tested: int) -> dict[str, Any]:
    """Return the figures of one training."""
    start = time.process_time()
    facts = find("stroke_cnn")
    recipe = Recipe.load(facts.recipe("quick"), changes=changes)
    trained, judged = _drawn(store, recipe, materials, tested)
    kind = signal_kind(trained)
    learner = build(Config(**recipe.config), kind, seed=recipe.seed)
    learner.setup(make_fabric(recipe.training))
    fit(learner, trained, seed=recipe.seed)
    windows, recordings = [], []
    for example in judged:
        true = kind.materials.index(example.material)
        windows.append(np.mean(learner.window_probabilities(example.signal).argmax(1) == true))
        recordings.append(learner.probabilities(example.signal).argmax() == true)
    return {
        "window_accuracy": float(np.mean(windows)),
        "recording_accuracy": float(np.mean(recordings)),
        "cpu_seconds": time.process_time() - start,
        "updates": learner.stages(trained)[-1].steps,
        "recordings": len(judged),
    }


def _drawn(store: Store, recipe: Recipe, materials: int, tested: int) -> tuple[Examples, Examples]:
    """Return one recording of each of the materials drawn, and others of them."""
    rng = np.random.default_rng(recipe.seed)
    by_material = defaultdict(list)
    for info in store.index:
        by_material[info.material or ""].append(info.id)
    chosen = rng.permutation(sorted(by_material))[:materials]
    drawn = [rng.permutation(by_material[name]) for name in chosen]
    parts = ([ids[0] for ids in drawn], [each for ids in drawn for each in ids[1 : tested + 1]])
    first, second = (
        Examples(store, [Segment(str(each)) for each in ids], recipe.prepare, label="material")
        for ids in parts
    )
    return first, second


def _spread(values: Sequence[float]) -> dict[str, float]:
    return {"mean": mean(values), "sd": stdev(values) if len(values) > 1 else 0.0}
