"""Accuracy and cost of `stroke_cnn` on few recordings: the shorter training of the recipe `quick`, and the whole one.

Two recordings of each material are trained on, one validates, others are judged. By default simulated strokes; `data`
is a store of others.
"""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.experiments.stroke_cnn_cost import spread
from tactogram.datasets import Store
from tactogram.datasets.examples import Examples, signal_kind
from tactogram.datasets.splits.split import Segment
from tactogram.errors import ParameterError
from tactogram.model import Stage
from tactogram.models import find
from tactogram.models.stroke_cnn.config import Config
from tactogram.models.stroke_cnn.learner import StrokeCNNLearner, build
from tactogram.recipe import Recipe
from tactogram.training.device import make_fabric
from tactogram.training.loop import fit
from tactogram.training.run import TrainingPosition
from tactogram.workflows.progress import ProgressCallback
from tactogram_benchmark.experiments.artifacts import cached_result, find_or_simulate, kind_of

FIGURES = ("window_accuracy", "recording_accuracy", "cpu_seconds")
ARMS = ("short", "classify")
"""Stages: the shorter training, and the whole one."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    band: Sequence[float] = (),
    materials: int = 5,
    tested: int = 10,
    seeds: int = 3,
) -> dict[str, Any]:
    """Return the accuracies and the processor time of both, per seed, and whether the shorter one would be kept.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    data : str
        Store; default: simulated.
    band : pair of float
        Pass band, Hz; default: all.
    materials, tested : int
        Materials drawn for each seed, and most recordings of each that are judged.
    seeds : int
        Seeds of the drawing and the training.
    """
    store = find_or_simulate(folder / "data", "stroking9", given=data, per_class=20, progress=progress)
    rows = []
    for seed in range(seeds):
        progress("seeds", seed, seeds)
        changes = {"seed": seed} | ({"prepare.band": list(band)} if band else {})
        measure = partial(_measured, store, changes, materials, tested)
        rows.append(cached_result(folder / f"{seed}.json", changes, measure))
    figures = {
        arm: {figure: spread([row[arm][figure] for row in rows]) for figure in FIGURES} for arm in ARMS
    }
    lines = [
        f"{arm:10}" + "".join(f"{name} {v['mean']:.3f} ± {v['sd']:.3f}   " for name, v in found.items())
        for arm, found in figures.items()
    ]
    kept = sum(row["short_training"]["kept"] for row in rows)
    head = (
        f"{kind_of(store)}, {seeds} seeds, 2 recordings of each of {materials} materials, kept {kept} times"
    )
    return {
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "rows": rows,
        "kept": kept,
        **figures,
        "text": "\n".join([head, *lines]),
    }


def _measured(store: Store, changes: dict[str, Any], materials: int, tested: int) -> dict[str, Any]:
    """Return the figures of both trainings; the whole one is made even if the shorter one would be kept."""
    recipe = Recipe.load(find("stroke_cnn").recipe("quick"), changes=changes)
    trained, validation, judged = _drawn(store, recipe, materials, tested)
    learner = build(Config(**recipe.config), signal_kind(trained), seed=recipe.seed)
    learner.setup(make_fabric(recipe.training))
    learner.set_validation(validation)
    found: dict[str, Any] = {"recordings": len(judged)}
    start = time.process_time()

    def end_of(position: TrainingPosition, stage: Stage, losses: dict[str, float]) -> None:
        nonlocal start
        if stage.name in ARMS and position.step == stage.steps:
            found[stage.name] = {"cpu_seconds": time.process_time() - start, **_accuracies(learner, judged)}
            start = time.process_time()

    fit(learner, trained, seed=recipe.seed, on_step=end_of)
    if not learner.outcome():
        raise ParameterError(
            f"{len(trained)} recordings are too many for a shorter training; lower materials"
        )
    found |= learner.outcome()
    if "classify" not in found:  # the same without a shorter training
        learner = build(Config(**recipe.config), signal_kind(trained), seed=recipe.seed)
        learner.setup(make_fabric(recipe.training))
        fit(learner, trained, seed=recipe.seed, on_step=end_of)
    return found


def _accuracies(learner: StrokeCNNLearner, judged: Examples) -> dict[str, float]:
    windows, recordings = [], []
    for example in judged:
        true = learner.materials.index(str(example.material))
        windows.append(np.mean(learner.window_probabilities(example.signal).argmax(1) == true))
        recordings.append(learner.probabilities(example.signal).argmax() == true)
    return {"window_accuracy": float(np.mean(windows)), "recording_accuracy": float(np.mean(recordings))}


def _drawn(store: Store, recipe: Recipe, materials: int, tested: int) -> list[Examples]:
    """Return the recordings to train on, to validate and to judge by."""
    rng = np.random.default_rng(recipe.seed)
    by_material = defaultdict(list)
    for info in store.index:
        by_material[info.material or ""].append(info.id)
    drawn = [rng.permutation(by_material[name]) for name in rng.permutation(sorted(by_material))[:materials]]
    parts = (slice(0, 2), slice(2, 3), slice(3, 3 + tested))
    return [
        Examples(
            store,
            [Segment(str(each)) for ids in drawn for each in ids[part]],
            recipe.prepare,
            label="material",
        )
        for part in parts
    ]
