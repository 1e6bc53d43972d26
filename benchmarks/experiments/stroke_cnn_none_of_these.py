"""Rejection of unknown surfaces by the surface search: materials held out of training, in turns, simulated.

Saga et al. propose the classifier as a search engine that grows the data base. That needs an honest "none of
these". Here the nine simulated surfaces of their generation experiment are held out three at a time.
"""

from __future__ import annotations

from pathlib import Path
from statistics import mean, stdev
from typing import Any

from tactogram.experiments.artifacts import find_or_simulate
from tactogram.workflows.evaluation.evaluate import evaluate
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.train import train

HELD_OUT_AT_ONCE = 3


def run(folder: Path, *, paper: bool, progress: ProgressCallback) -> dict[str, Any]:
    """Return, over the turns, how many known recordings pass, unknown ones are refused, and the AUROC."""
    data = folder / "data"
    store = find_or_simulate(data, "stroking9", per_class=30, progress=progress)
    names = sorted({str(info.material) for info in store.index})
    turns = [names[i::HELD_OUT_AT_ONCE] for i in range(len(names) // HELD_OUT_AT_ONCE)]
    rows = []
    for number, held_out in enumerate(turns):
        out = folder / f"turn-{number}"
        options: dict[str, Any] = {"recipe": "paper"} if paper else {"changes": {"config.steps": 200}}
        train(
            "stroke_cnn",
            data,
            where={"material": "!" + "|".join(held_out)},
            out=out,
            resume=(out / "recipe.toml").exists(),
            **options,
            progress=progress,
        )
        found = evaluate(out, unknown=True, progress=progress)
        rows.append({"held_out": held_out, **found["none_of_these"]})
    figures = {
        name: {"mean": mean(values), "sd": stdev(values)}
        for name in ("known_kept", "unknown_rejected", "auroc")
        if (values := [row[name] for row in rows])
    }
    text = "\n".join(f"{name:18}{v['mean']:.3f} ± {v['sd']:.3f}" for name, v in figures.items())
    return {
        "simulated": store.simulated,
        "data": store.name,
        "data_sha256": store.sha256,
        "turns": rows,
        **figures,
        "text": f"Simulated surfaces, {len(rows)} turns, {HELD_OUT_AT_ONCE} of {len(names)} held out.\n{text}",
    }
