"""Hatori & Takemura 2023, Sec. IV-C: groups whose training succeeds, by the printed rule and by ours; Figure 6.

A cluster is a run of its own, on all recordings of its plates as published (there is no test part). The
clusters of Ward's tree are nested, so groups share them: A to D are seven trainings, E eleven more. Each run keeps the
generator of the printed rule; ours, which averages the correct rate, is applied to the same curves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.cli.printing import columns
from tactogram.errors import ParameterError, Remedy
from tactogram.evaluation import NEAREST, STRAIGHT, SelectionRule, choose, reproduction, smoothed
from tactogram.models.ultrasonic_cgan import Config, clusters_of, tree_of
from tactogram.signal import Signal
from tactogram.workflows import ProgressCallback, WordGenerationResult, generate_rated_surfaces, load_run
from tactogram_benchmark.experiments.artifacts import (
    Training,
    facts_of,
    find_or_simulate,
    trained_runs,
)
from tactogram_benchmark.experiments.image_cells import plates_of
from tactogram_benchmark.experiments.ultrasonic_cgan_figure7 import (
    GROUPS,
    PEOPLE,
    SIMULATED_RATERS,
    chosen_groups,
)
from tactogram_simulate import draw_people, score_vibrations

PUBLISHED = {"A": True, "B": True, "C": True, "D": True, "E": False}
"""Whether the training succeeded. Sec. IV-C."""
RULES = ("as printed", "ours")
"""The correct rate of one batch, or of the last 100."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    data: str = "",
    groups: str = "A,B,C,D,E",
    finished: bool = False,
    on: str = "",
    processes: int | None = None,
) -> dict[str, Any]:
    """Return the outcome of each cluster's training by both rules, of each group, and the errors of its signals.

    Parameters
    ----------
    folder, paper, progress
        See `tactogram_benchmark.experiments`; ``paper`` is 18 trainings of 200,000 iterations, half an hour each on
        a core.
    data : str
        Store of rated plates and display signals; default: the simulated study.
    groups : str
        Names, separated by commas.
    finished : bool
        Report the runs that are finished, and train none.
    """
    store = find_or_simulate(folder / "data", "ultrasonic", given=data, progress=progress)
    plates = plates_of(store)
    tree = tree_of(plates.means, Config().linkage)
    members: dict[str, list[tuple[str, ...]]] = {}
    for name in chosen_groups(groups):
        numbers = clusters_of(tree, GROUPS[name], items=len(plates.names))
        members[name] = [tuple(np.array(plates.names)[numbers == k].tolist()) for k in range(GROUPS[name])]
    recipe = "paper" if paper else "quick"
    changes = {"config.clusters": 1, "config.smooth": 1}
    clusters: dict[tuple[str, ...], dict[str, Any]] = {}
    surfaces: dict[tuple[str, ...], WordGenerationResult] = {}
    runs: dict[tuple[str, ...], Training] = {}
    for plates_in in dict.fromkeys(cluster for held in members.values() for cluster in held):
        others = [name for name in plates.names if name not in plates_in]
        where = {"material": "!" + "|".join(others)} if others else None
        runs[plates_in] = Training(
            "ultrasonic_cgan",
            store.path,
            folder / "runs" / ("plates-" + "-".join(name.removeprefix("plate") for name in plates_in) + "-0"),
            {"recipe": recipe, "split": "all", "changes": changes, "where": where},
        )
    if finished:
        runs = {name: training for name, training in runs.items() if (training.run / "model.json").is_file()}
    for plates_in, out in trained_runs(runs, on=on, processes=processes, progress=progress):
        clusters[plates_in] = _outcome(out) | {
            "plates": list(plates_in),
            "figure": (out / "figures/spectra.png").relative_to(folder).as_posix(),
        }
        surfaces[plates_in] = generate_rated_surfaces(out)
    if not clusters:
        raise ParameterError(folder, "must hold a finished run, got none", remedy=Remedy("omit", "finished"))
    result: dict[str, Any] = {
        **facts_of(store),
        "recipe": recipe,
        "split": "none: all recordings are trained on, as published; rated signals are of recordings trained on",
        "clusters": list(clusters.values()),
        "groups": {
            name: {"published": PUBLISHED[name]} | _group([clusters.get(cluster) for cluster in held])
            for name, held in members.items()
        },
        "told_by": _told(members, surfaces) if store.simulated else {},
    }
    return result | {"text": _text(result)}


def _outcome(out: Path) -> dict[str, Any]:
    """Return what a training's curves show, and the iteration that each rule selects."""
    model: Any = load_run(out).model
    losses, _, rates = model.trained[0].curves
    averaged = smoothed(rates, SelectionRule().window)
    rules = {
        "as printed": SelectionRule(window=1, after=model.config.choose_after),
        "ours": SelectionRule(after=model.config.choose_after),
    }
    chosen = {name: choose(losses, rates, rule) for name, rule in rules.items()}
    return {
        "iterations": len(rates),
        "correct_rate": float(rates.mean()),
        "lowest_smoothed": float(np.nanmin(averaged)),
        "lowest_smoothed_at": int(np.nanargmin(averaged)) + 1,
        "single_in_range": int(((rates >= 0.4) & (rates <= 0.6)).sum()),
        **{name: None if choice is None else asdict(choice) for name, choice in chosen.items()},
    }


def _group(held: Sequence[Mapping[str, Any] | None]) -> dict[str, Any]:
    """Return a group's number of clusters, of finished trainings, and of those in which a generator was selected."""
    done = [outcome for outcome in held if outcome is not None]
    met = {name: sum(outcome[name] is not None for outcome in done) for name in RULES}
    return {"clusters": len(held), "finished": len(done), **met}


def _told(
    members: Mapping[str, Sequence[tuple[str, ...]]], surfaces: Mapping[tuple[str, ...], WordGenerationResult]
) -> dict[str, Any]:
    """Return the errors of simulated people's scores, of the printed rule's generators and without a model."""
    signals: dict[str, Signal] = {}
    for held in surfaces.values():
        signals |= {f"{STRAIGHT}/{item}": signal for item, signal in held.straight.items()}
        signals |= {f"{NEAREST}/{item}": signal for item, signal in held.nearest.items()}
    for name, clusters in members.items():
        for held in (surfaces[cluster] for cluster in clusters if cluster in surfaces):
            signals |= {f"{name}/{item}": signal for item, signal in held.signals.items()}
    first = next(iter(surfaces.values()))
    targets = {item: np.array(row) for held in surfaces.values() for item, row in held.targets.items()}
    people = draw_people(PEOPLE, seed=1, prefix="judge")
    said = score_vibrations(signals, people, seed=0).in_words(first.ratings.words)
    conditions = (STRAIGHT, NEAREST, *members)
    return reproduction(said, targets, conditions=conditions, told_by=SIMULATED_RATERS).as_dict()


def _text(result: Mapping[str, Any]) -> str:
    table: list[tuple[str, ...]] = [("plates", "iterations", "correct", "lowest of 100", *RULES)]
    for cluster in result["clusters"]:
        plates = ",".join(name.removeprefix("plate") for name in cluster["plates"])
        rates = (f"{cluster['correct_rate']:.3f}", f"{cluster['lowest_smoothed']:.3f}")
        table.append(
            (plates, f"{cluster['iterations']:,}", *rates, *(_chosen(cluster[name]) for name in RULES))
        )
    lines = [
        f"Selection on {result['data']}, recipe {result['recipe']}; split: {result['split']}",
        columns(table),
    ]
    for name, group in result["groups"].items():
        met = ", ".join(f"{group[rule]} {rule}" for rule in RULES)
        lines.append(
            f"group {name}: {group['finished']} of {group['clusters']} clusters finished; generators selected: {met}; "
            f"published: {'all' if group['published'] else 'failed'}"
        )
    for name, row in result["told_by"].get("conditions", {}).items():
        lines.append(f"{name}: MAE {row['mae']:.3f} ± {row['se']:.3f} (SE), {row['targets']} plates")
    return "\n".join(lines)


def _chosen(choice: Mapping[str, Any] | None) -> str:
    return "failed" if choice is None else f"{choice['iteration']:,} (loss {choice['loss']:.3g})"
