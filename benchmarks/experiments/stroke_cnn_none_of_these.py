"""Rejection of unknown surfaces by the surface search: materials held out of training, in several draws and seeds.

Saga et al. propose the classifier as a search engine that grows the data base. That needs an honest "none of
these". By default the surfaces are the nine simulated ones of their generation experiment; `data` is a store of others.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import mean, stdev
from typing import Any

import numpy as np

from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.progress import ProgressCallback
from tactogram_benchmark.experiments.artifacts import find_or_simulate, kind_of, trained_run

FIGURES = ("known_kept", "unknown_rejected", "auroc", "recording_accuracy", "window_accuracy")


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    band: Sequence[float] = (),
    held_out: int = 3,
    turns: int = 3,
    seeds: int = 1,
    steps: int = 0,
    precision: str = "auto",
) -> dict[str, Any]:
    """Return, over turns and seeds, how many known recordings pass, unknown ones are refused, and the AUROC.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment.
    data : str
        Store; default: simulated.
    band : pair of float
        Pass band, Hz; default: all.
    held_out : int
        Materials left out of a training.
    turns : int
        Trainings of one seed, whose materials left out differ, as far as there are enough.
    seeds : int
        Seeds of the materials' order, the split and the training.
    steps : int
        Updates of ``quick``, if not its own number.
    precision : str
        ``training.precision``.
    """
    store = find_or_simulate(folder / "data", "stroking9", given=data, per_class=30, progress=progress)
    names = sorted({str(info.material) for info in store.index})
    changes: dict[str, Any] = {"training.precision": precision}
    changes |= {"prepare.band": list(band)} if band else {}
    changes |= {"config.steps": steps} if steps else {}
    rows = []
    for seed in range(seeds):
        order = np.random.default_rng(seed).permutation(names).tolist() * 2
        for turn in range(turns):
            unknown = sorted(order[turn * held_out : (turn + 1) * held_out])
            out = trained_run(
                "stroke_cnn",
                store,
                folder / f"seed-{seed}-turn-{turn}",
                recipe="paper" if paper else "quick",
                changes={**changes, "seed": seed},
                where={"material": "!" + "|".join(unknown)},
                progress=progress,
            )
            found = evaluate(out, unknown=True, progress=progress)
            accuracies = {name: found[name] for name in ("recording_accuracy", "window_accuracy")}
            rows.append({"seed": seed, **accuracies, **found["none_of_these"]})
    figures = {
        name: {"mean": mean(values), "sd": stdev(values)}
        for name in FIGURES
        if len(values := [row[name] for row in rows]) > 1
    }
    text = "\n".join(f"{name:20}{v['mean']:.3f} ± {v['sd']:.3f}" for name, v in figures.items())
    return {
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "changes": changes,
        "rows": rows,
        **figures,
        "text": f"{kind_of(store)}, {len(rows)} trainings, {held_out} of {len(names)} materials held out.\n{text}",
    }
