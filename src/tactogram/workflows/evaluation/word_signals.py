"""Signals of a generator conditioned on words, for each rated surface."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Ratings
from tactogram.errors import FailedTrainingError, ParameterError, Remedy
from tactogram.evaluation.ratings.reproduction import NEAREST, STRAIGHT
from tactogram.evaluation.report import ReportSection, ReportTable, ReportText
from tactogram.model import Example
from tactogram.signal import Signal
from tactogram.signal.crest_factor import straight_to_display
from tactogram.workflows.evaluation.ratings import evaluate_reproduction, predicted_ratings
from tactogram.workflows.training.loaded_run import LoadedRun, load_run, test_part
from tactogram.workflows.training.rated_examples import RatingData


@dataclass(frozen=True, eq=False)
class WordGenerationResult:
    """Signals of a run by surface, with those to compare them with.

    ``failed`` has the reasons of surfaces without a signal; ``targets`` the mean scores of the surfaces, on the raters'
    scale, in the order of ``ratings.words``; ``straight`` the sensor's signal, straight to the display; ``nearest`` the
    display signal nearest in words; ``recordings`` a description of the recordings.
    """

    signals: Mapping[str, Signal]
    failed: Mapping[str, str]
    targets: Mapping[str, tuple[float, ...]]
    straight: Mapping[str, Signal]
    nearest: Mapping[str, Signal]
    ratings: Ratings
    recordings: str


def generate_rated_surfaces(run: Path | str | LoadedRun, *, seed: int = 0) -> WordGenerationResult:
    """Return the signals of a run trained on rated surfaces and rated signals, for each surface.

    The condition is the surface's mean scores and one recording: its first test recording, else one for validation,
    else one that was trained on, as ``recordings`` says.

    Raises `ParameterError` if the run was not trained on both, or generates no signals.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    if loaded.facts.learns_from != "both" or loaded.facts.gives != "signal":
        raise ParameterError(
            f"{loaded.run.name}: must make signals from rated surfaces and rated signals; {loaded.facts.name} does not"
        )
    store, split = test_part(loaded.run)
    rated = RatingData(store, loaded.facts.learns_from)
    surfaces: dict[str, Example] = {}
    parts: Counter[str] = Counter()
    for part in ("test", "validation", "train"):  # a surface may have no test recording
        for example in rated.examples(split, part, loaded.recipe.prepare):
            if example.material is not None and str(example.item) not in surfaces:
                surfaces[str(example.item)] = example
                parts[part] += 1
    played = {
        str(example.item): example.signal
        for example in rated.examples(split, "train", loaded.recipe.prepare)
        if example.material is None
    }
    ratings = rated.ratings
    means = dict(zip(ratings.items, ratings.means, strict=True))
    signals, failed = {}, {}
    for item, example in sorted(surfaces.items()):
        words = dict(zip(ratings.words, means[item].tolist(), strict=True))
        try:
            signal = loaded.generator.generate({"words": words, "vibration": example.signal}, seed=seed)
        except FailedTrainingError as error:
            failed[item] = error.message.problem
            continue
        if isinstance(signal, Signal):
            signals[item] = signal
    kind = loaded.kind
    return WordGenerationResult(
        signals,
        failed,
        {item: tuple(means[item].tolist()) for item in sorted(surfaces)},
        {
            item: straight_to_display(e.signal, rate=kind.rate, axes=kind.axes)
            for item, e in sorted(surfaces.items())
        },
        {item: played[_nearest(means[item], {n: means[n] for n in played})] for item in sorted(surfaces)},
        ratings,
        ", ".join(f"{count} of the {part} part" for part, count in parts.items()),
    )


def evaluate_rated_surfaces(
    loaded: LoadedRun, *, rater: Path | str | LoadedRun | None, seed: int = 0
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return the errors of a rater model's scores of a run's signals, against the ratings of the surfaces.

    The figures are ``data``, ``rater``, ``failed`` (surfaces without a signal, with reasons) and those of
    `tactogram.workflows.evaluation.ratings.evaluate_reproduction`, of ``sensor``, ``nearest`` and the run.

    Raises `ParameterError` if there is no rater, or it scores on another scale than that of the surfaces.
    """
    if rater is None:
        raise ParameterError(
            loaded.run.name,
            f"{loaded.facts.name} is evaluated by rated signals",
            remedy=Remedy(
                "give a run of the model rater trained on the display signals (prepare.stream) as", "rater"
            ),
        )
    scorer = rater if isinstance(rater, LoadedRun) else load_run(rater)
    result = generate_rated_surfaces(loaded, seed=seed)
    scale = (result.ratings.scale.low, result.ratings.scale.high)
    if scorer.any_kind.scale != scale:
        raise ParameterError(
            scorer.run.name,
            f"must score on the scale of the surfaces, {scale[0]:g} to {scale[1]:g}, got {scorer.any_kind.scale}",
            parameter="rater",
        )
    name = loaded.run.name
    kinds = {STRAIGHT: result.straight, NEAREST: result.nearest, name: result.signals}
    signals = {f"{kind}/{item}": signal for kind, held in kinds.items() for item, signal in held.items()}
    told_by = "a rater model" + (" of simulated raters" if scorer.simulated else "")
    figures = evaluate_reproduction(
        predicted_ratings(scorer, signals).in_words(result.ratings.words),
        result.targets,
        conditions=tuple(kinds),
        told_by=told_by,
        out=loaded.run.folder / "reproduction.png",
    )
    simulated = loaded.simulated or scorer.simulated
    facts = {
        "model": loaded.facts.name,
        "run": loaded.run.data["run_id"],
        "data": {
            "name": loaded.run.data["name"],
            "sha256": loaded.run.data["sha256"],
            "split": f"{len(result.targets)} rated surfaces, one recording each: {result.recordings}",
            "simulated": simulated,
        },
        "rater": {
            "run": scorer.run.data["run_id"],
            "described_by": scorer.model.feature_description,
        },
        "failed": dict(result.failed),
    }
    rows = [(n, r["mae"], r["se"], r["targets"]) for n, r in figures["conditions"].items()]
    rows += [(n, value, None, "–") for n, value in figures["beside"].items()]
    blocks: list[Any] = [
        ReportTable(
            ("condition", "mean absolute error", "SE", "surfaces"),
            rows,
            f"Points of the scale, rated by {told_by}. If it was trained on the display signals, its scores of "
            f"{NEAREST!r}, or of a copy, are closer than those of an unknown signal.",
        ),
    ]
    blocks += [ReportText(f"{item}: {why}.") for item, why in result.failed.items()]
    return facts | figures, [ReportSection("Ratings of the signals", blocks)]


def _nearest(target: Any, means: Mapping[str, Any]) -> str:
    return min(means, key=lambda name: float(np.nansum((means[name] - target) ** 2)))
