"""ultrasonic_cgan: clusters, number of display signals and two discriminators, on simulated data.

Hatori & Takemura 2023 attribute the failure of fine clusters to "the reduction in the training datasets" (Sec. VI). A
cluster has fewer plates but sees all display signals, so this experiment varies both: the paper's groups of clusters,
and 40, 400 or 4,000 display signals. The second discriminator sees words only in an inner product (``projection``).

Each CGAN has the recipe ``quick`` without its slower discriminator, and the generator of the last iteration, so that
cells are comparable whether or not the selection rule is met; ``met`` counts the clusters in which it was.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from pathlib import Path
from statistics import mean, stdev
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from tactogram.datasets import Ratings
from tactogram.datasets.simulate.raters import SimulatedRater, draw_people, score_vibrations
from tactogram.datasets.simulate.studies import drives
from tactogram.evaluation.checkpoint_selection import SelectionRule, choose
from tactogram.evaluation.ratings.reproduction import NEAREST, STRAIGHT, label_fidelity
from tactogram.models.ultrasonic_cgan import Config
from tactogram.models.ultrasonic_cgan.spectra import display_spectra
from tactogram.signal import Signal
from tactogram.workflows.evaluation.word_signals import generate_rated_surfaces
from tactogram.workflows.progress import ProgressCallback
from tactogram.workflows.training.loaded_run import LoadedRun, load_run
from tactogram.workflows.training.rated_examples import RatingData
from tactogram_benchmark.experiments.artifacts import cached_result, find_or_simulate, trained_run

SIGNALS = (40, 400, 4000)
CLUSTERS = (1, 4, 12)
"""Groups A, D and E. Sec. IV-B."""
DISCRIMINATORS = ("concatenated", "projection")
ITERATIONS = 1500
PEOPLE = 20
"""Simulated people who took no part in the training data, as in Sec. V-A."""
UNSEEN = 200
"""Display signals that no training has, and at most as many of the training, for what a discriminator knows by heart.
They are drawn; the first 39 of each training are the study's, so that with 40 they also differ in kind."""
VARIED = ("seed", "config.clusters", "config.discriminator")
VALIDATED = ("told_apart_unseen", "to_nearest_display", "between_surfaces")
"""Of `tactogram.models.ultrasonic_cgan.cluster_evaluation`."""
EACH = 8
"""Raters drawn for each of them."""


def run(
    folder: Path,
    *,
    paper: bool,
    progress: ProgressCallback,
    signals: Sequence[int] = SIGNALS,
    clusters: Sequence[int] = CLUSTERS,
    trainings: int = 1,
    iterations: int = 0,
    rate: float = 0.0,
) -> dict[str, Any]:
    """Return a row per discriminator, number of display signals and number of clusters.

    Parameters
    ----------
    folder, paper, progress
        As of every experiment; ``paper`` trains the published networks for 200,000 iterations.
    signals, clusters : sequence of int
    trainings : int
        Seeds per cell.
    iterations : int
        Of each CGAN; 0 for 1,500, or 200,000 with ``paper``.
    rate : float
        The discriminator's learning rate; 0 for Table 4's.
    """
    changes: dict[str, Any] = {"config.iterations": iterations or (200_000 if paper else ITERATIONS)}
    changes |= {"config.discriminator_learning_rate": rate or 1e-3}
    recipe = "paper" if paper else "quick"
    # The last generator, whatever its rate: the rule is applied to the curves.
    last = changes["config.iterations"] - 1
    changes |= {
        "config.rate_low": 0.0, "config.rate_high": 1.0, "config.smooth": 1, "config.choose_after": last,
    }  # fmt: skip
    stores = {
        count: find_or_simulate(folder / f"data-{count}", "ultrasonic", signals=count, progress=progress)
        for count in signals
    }
    people = draw_people(PEOPLE, seed=1, prefix="judge")
    unseen = score_vibrations(
        {d.name: d.signal for d in drives(max(SIGNALS) + UNSEEN)[-UNSEEN:]}, draw_people(32, seed=0), seed=0
    )
    cells: dict[tuple[str, int, int], list[dict[str, Any]]] = {}
    baselines: dict[int, dict[str, dict[str, float]]] = {}
    for count, store in stores.items():
        ratings = RatingData(store, "both").ratings
        plates = ratings.select(items=[item for item in ratings.items if item.startswith("plate")])
        names = [item for item in ratings.items if item.startswith("signal")]
        some = np.linspace(0, len(names) - 1, min(UNSEEN, len(names))).round().astype(int)
        seen = ratings.select(items=[names[place] for place in some])
        for seed, kind, groups in product(range(trainings), DISCRIMINATORS, clusters):
            changes |= {"config.clusters": groups, "config.discriminator": kind, "seed": seed}
            out = folder / "runs" / f"{count}-{kind}-{groups}-{seed}"
            trained_run(
                "ultrasonic_cgan", store, out, recipe=recipe, by="session", changes=changes, progress=progress
            )
            loaded = load_run(out)
            facts = {"run_id": loaded.run.data["run_id"], "unseen": UNSEEN, "each": EACH}

            def evaluated() -> dict[str, Any]:
                return _cell(loaded, people, (seen, unseen, plates))  # noqa: B023

            cell = cached_result(folder / "cells" / f"{out.name}.json", facts, evaluated)
            cells.setdefault((kind, count, groups), []).append(cell)
            if count not in baselines:
                baselines[count] = _baselines(loaded, people)
    rows = [
        {"discriminator": kind, "signals": count, "clusters": groups} | _summary(held)
        for (kind, count, groups), held in sorted(cells.items())
    ]
    result = {
        "simulated": True,
        "data": "ultrasonic (simulated)",
        "data_sha256": {count: store.sha256 for count, store in stores.items()},
        "split": "rated surfaces by session; one unseen recording of each",
        "told_by": f"{PEOPLE} other simulated raters",
        "trainings": trainings,
        "recipe": recipe,
        "changes": {name: value for name, value in changes.items() if name not in VARIED},
        "baselines": baselines,
        "rows": rows,
    }
    return result | {"text": _text(result)}


def _cell(
    loaded: LoadedRun, people: Sequence[SimulatedRater], rated: tuple[Ratings, Ratings, Ratings]
) -> dict[str, Any]:
    """Return the figures of one training."""
    model: Any = loaded.model
    made = generate_rated_surfaces(loaded)
    rule = SelectionRule()
    chosen = [choose(one.curves[0], one.curves[2], rule) for one in model.trained]
    rates = [float(one.curves[2, -500:].mean()) for one in model.trained]
    unseen = loaded.run.facts()["validation"]
    return {
        "met": sum(one is not None for one in chosen),
        "correct_rate": mean(rates),
        **_errors(made.signals, made.targets, people),
        **_known_by_heart(model, *rated),
        **{name: unseen[name] for name in VALIDATED if name in unseen},
    }


def _errors(
    signals: Mapping[str, Signal], targets: Mapping[str, Sequence[float]], people: Sequence[SimulatedRater]
) -> dict[str, float]:
    """Return the error of simulated people's scores from the plates', and how closely the scores follow the plates'."""
    said = score_vibrations(signals, people, seed=0)  # in the order of the store's words
    asked = np.array([targets[item] for item in said.items])
    fidelity = label_fidelity(asked, np.asarray(said.means)[:, None])
    return {
        "mae": float(np.nanmean(np.abs(said.cube - asked[:, None]))),
        "correlation": fidelity.correlation,
        "slope": fidelity.slope,
    }


def _known_by_heart(model: Any, seen: Ratings, unseen: Ratings, plates: Ratings) -> dict[str, float]:
    """Return what the discriminators take for training data, means over the clusters.

    ``accepted_seen`` and ``accepted_unseen`` are shares of display signals, of the training and others, with single
    raters' scores of them. ``words_alone`` is the balanced accuracy on display signals of the training, with scores of
    them on one side and of the cluster's plates on the other: at 0.5, words alone do not distinguish the sides.
    """
    found = []
    for cluster, one in enumerate(model.trained):
        members = plates.select(items=list(model.surfaces.members(cluster)))
        own, other = (_accepted(model, one, ratings, ratings) for ratings in (seen, unseen))
        foreign = _accepted(model, one, seen, members)
        found.append((own, other, (own + 1 - foreign) / 2))
    means = np.mean(found, axis=0).tolist()
    return dict(zip(("accepted_seen", "accepted_unseen", "words_alone"), means, strict=True))


@torch.inference_mode()
def _accepted(model: Any, trained: Any, shown: Ratings, scored: Ratings) -> float:
    """Return the share of display signals taken for training data, with scores of themselves or drawn of others."""
    rng = np.random.default_rng(0)
    spectra = np.stack([_spectra()[item] for item in shown.items])
    scores = [scored.rated(item).scores for item in scored.items]
    same = shown is scored
    drawn = [
        scores[place if same else rng.integers(len(scores))][rng.integers(0, 20, EACH)]
        for place in range(len(shown.items))
    ]  # of the first 20 raters, none of whom lacks an item
    x = np.repeat(spectra / model.surfaces.display_scale, EACH, axis=0)
    given = np.concatenate((x, np.nan_to_num(np.concatenate(drawn), nan=0.5)), 1).astype(np.float32)
    verdict = trained.discriminator(torch.from_numpy(given))
    return float((verdict > 0).float().mean())


@cache
def _spectra() -> dict[str, NDArray[np.float32]]:
    """Return the spectrum of each display signal, (bin,)."""
    shown = drives(max(SIGNALS) + UNSEEN)
    return {drive.name: display_spectra(drive.signal, Config())[0, 0] for drive in shown}


def _baselines(loaded: LoadedRun, people: Sequence[SimulatedRater]) -> dict[str, dict[str, float]]:
    """Return the figures of the sensor's signal, and of the display signal nearest in words."""
    made = generate_rated_surfaces(loaded)
    kinds = {STRAIGHT: made.straight, NEAREST: made.nearest}
    return {name: _errors(signals, made.targets, people) for name, signals in kinds.items()}


def _summary(cells: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return mean and sd of each figure over the trainings."""
    names = [name for name in cells[0] if name != "asked"]
    values = {name: [float(cell[name]) for cell in cells] for name in names}
    spread = {f"{name}_sd": stdev(held) for name, held in values.items() if len(held) > 1}
    return {name: mean(held) for name, held in values.items()} | spread


COLUMNS = {
    "mae": "MAE", "slope": "slope", "correlation": "corr.", "met": "met", "correct_rate": "correct",
    "words_alone": "words", "accepted_seen": "seen", "accepted_unseen": "unseen", "to_nearest_display": "nearest",
    "between_surfaces": "between",
}  # fmt: skip


def _text(result: Mapping[str, Any]) -> str:
    lines = [
        f"Simulated plates and display signals, rated by {result['told_by']}; {result['trainings']} training(s).",
        f"{'discriminator':14}{'signals':>8}{'clusters':>9}"
        + "".join(f"{title:>9}" for title in COLUMNS.values()),
    ]
    lines += [
        f"{row['discriminator']:14}{row['signals']:>8}{row['clusters']:>9}"
        + "".join(f"{row[name]:>9.2f}" if name in row else f"{'-':>9}" for name in COLUMNS)
        for row in result["rows"]
    ]
    lines += [
        f"{name:14}{count:>8}{'':>9}"
        + "".join(f"{row[key]:>9.2f}" for key in ("mae", "slope", "correlation"))
        for count, kinds in result["baselines"].items()
        for name, row in kinds.items()
    ]
    return "\n".join(lines)
