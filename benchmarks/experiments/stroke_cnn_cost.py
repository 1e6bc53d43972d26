"""Cost and accuracy of the recipe `quick` of stroke_cnn with and without bfloat16, paired by split and seed.

`quick` takes bfloat16 where the processor or GPU multiplies it faster. By default on simulated strokes; `data` is a
store of others.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from statistics import mean, stdev
from typing import Any

from tactogram.workflows.evaluation.crossval import crossval
from tactogram.workflows.progress import ProgressCallback
from tactogram_benchmark.experiments.artifacts import cached_result, find_or_simulate, kind_of

RECIPES: dict[str, dict[str, Any]] = {
    "float32": {"training.precision": "32-true"},
    "quick": {},
}
FIGURES = ("window_accuracy", "recording_accuracy", "cpu_seconds")


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    band: Sequence[float] = (),
    axes: str = "all",
    seeds: int = 3,
) -> dict[str, Any]:
    """Return the accuracies and the processor time of both, per seed, with their differences.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` changes nothing.
    data : str
        Store; default: simulated.
    band : pair of float
        Pass band, Hz; default: all.
    axes : str
        ``prepare.axes`` of both.
    seeds : int
        Seeds of the split, of which the first of four folds is tested, and of the training.
    """
    store = find_or_simulate(folder / "data", "stroking9", given=data, per_class=20, progress=progress)
    shared: dict[str, Any] = {"prepare.axes": axes}
    shared |= {"prepare.band": list(band)} if band else {}
    rows = []
    for seed in range(seeds):
        row: dict[str, Any] = {"seed": seed}
        for name, differing in RECIPES.items():
            progress(f"seed {seed}", seed + 1, seeds, name)
            changes = {**shared, **differing, "seed": seed}
            measure = partial(_measured, store.path, folder / f"{name}-{seed}", changes)
            row[name] = cached_result(folder / f"{name}-{seed}.json", changes, measure)
        rows.append(row)
    figures = {
        figure: {name: spread([row[name][figure] for row in rows]) for name in RECIPES}
        | {"difference": spread([row["quick"][figure] - row["float32"][figure] for row in rows])}
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
        "shared": shared,
        "rows": rows,
        **figures,
        "text": "\n".join([f"{kind_of(store)}, {seeds} seeds, the first of 4 folds by recording", *lines]),
    }


def _measured(data: Path | str, out: Path, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the figures of one fold, with the processor's time for all of it."""
    start = time.process_time()
    found = crossval("stroke_cnn", data, folds=4, only_folds=1, changes=changes, out=out)
    found["cpu_seconds"] = time.process_time() - start
    return {figure: found[figure] for figure in (*FIGURES, "recordings", "windows")}


def spread(values: Sequence[float]) -> dict[str, float]:
    """Return mean and standard deviation over seeds."""
    return {"mean": mean(values), "sd": stdev(values) if len(values) > 1 else 0.0}
