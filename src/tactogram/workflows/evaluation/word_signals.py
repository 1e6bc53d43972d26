"""Signals of a generator conditioned on words, for each rated surface."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.datasets import Ratings
from tactogram.errors import FailedTrainingError, ParameterError
from tactogram.evaluation.ratings.reproduction import NEAREST, STRAIGHT
from tactogram.evaluation.report import ReportSection, ReportTable, ReportText
from tactogram.model import Example, feature_description
from tactogram.signal import Signal
from tactogram.signal.full_scale import straight_to_display
from tactogram.workflows.evaluation.ratings import evaluate_reproduction, predicted_ratings
from tactogram.workflows.training.loaded_run import LoadedRun, load_run, test_part
from tactogram.workflows.training.rated_examples import RatingData


@dataclass(frozen=True, eq=False)
class WordGenerationResult:
    """A run's signals, and what they are to be held against.

    Parameters
    ----------
    signals : mapping from str to Signal
        By surface.
    failed : mapping from str to str
        Surfaces of which nothing was made, and why.
    targets : mapping from str to tuple of float
        Mean scores of the surfaces themselves, on the raters' scale, in the order of ``ratings.words``.
    straight : mapping from str to Signal
        The sensor's signal of each surface, straight to the display.
    nearest : mapping from str to Signal
        The display signal nearest in words to each surface.
    ratings : Ratings
        All that the run's data was rated.
    recordings : str
        Which recordings the sensor's signals are of, in words.
    """

    signals: Mapping[str, Signal]
    failed: Mapping[str, str]
    targets: Mapping[str, tuple[float, ...]]
    straight: Mapping[str, Signal]
    nearest: Mapping[str, Signal]
    ratings: Ratings
    recordings: str


def generate_rated_surfaces(run: Path | str | LoadedRun, *, seed: int = 0) -> WordGenerationResult:
    """Return what a run that learned from rated surfaces and rated signals makes of each surface.

    Each surface is asked for by its mean scores and one recording of it: the first that was kept for testing, or
    for validation; one that was trained on where there is no other, which ``recordings`` says.

    Raises
    ------
    ParameterError
        If the run did not learn from both, or gives no signals.
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
    for part in ("test", "validation", "train"):  # a surface may have no recording that was kept apart
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
            made = loaded.generator.generate({"words": words, "vibration": example.signal}, seed=seed)
        except FailedTrainingError as error:
            failed[item] = re.sub(r"; ask for.*", "", str(error))
            continue
        if isinstance(made, Signal):
            signals[item] = made
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
    """Return how far what a rater model says of a run's signals lies from what was said of the surfaces.

    Returns
    -------
    dict and list of Section
        ``data``, ``rater`` (which run), ``failed`` (surfaces without a signal, and why) and what
        `tactogram.workflows.evaluation.ratings.evaluate_reproduction` gives, of ``sensor``, ``nearest`` and the run.

    Raises
    ------
    ParameterError
        If there is no rater, or it scores on another scale than that of the surfaces.
    """
    if rater is None:
        raise ParameterError(
            f"{loaded.run.name}: {loaded.facts.name} is evaluated by rated signals; give `rater`, a run "
            "of the model rater that was trained on the display signals (prepare.stream)"
        )
    judge = rater if isinstance(rater, LoadedRun) else load_run(rater)
    made = generate_rated_surfaces(loaded, seed=seed)
    scale = (made.ratings.scale.low, made.ratings.scale.high)
    if judge.any_kind.scale != scale:
        raise ParameterError(
            f"{judge.run.name}: `rater` must score on the scale of the surfaces, {scale[0]:g} to {scale[1]:g}; "
            f"got {judge.any_kind.scale}"
        )
    name = loaded.run.name
    kinds = {STRAIGHT: made.straight, NEAREST: made.nearest, name: made.signals}
    given = {f"{kind}/{item}": one for kind, held in kinds.items() for item, one in held.items()}
    told_by = "a rater model" + (" of simulated raters" if judge.simulated else "")
    figures = evaluate_reproduction(
        predicted_ratings(judge, given).in_words(made.ratings.words),
        made.targets,
        conditions=tuple(kinds),
        told_by=told_by,
        out=loaded.run.folder / "reproduction.png",
    )
    simulated = loaded.simulated or judge.simulated
    facts = {
        "model": loaded.facts.name,
        "run": loaded.run.data["run_id"],
        "data": {
            "name": loaded.run.data["name"],
            "sha256": loaded.run.data["sha256"],
            "split": f"{len(made.targets)} rated surfaces, one recording each: {made.recordings}",
            "simulated": simulated,
        },
        "rater": {
            "run": judge.run.data["run_id"],
            "described_by": feature_description(judge.model),
        },
        "failed": dict(made.failed),
    }
    rows = [(n, r["mae"], r["se"], r["targets"]) for n, r in figures["conditions"].items()]
    rows += [(n, value, None, "–") for n, value in figures["beside"].items()]
    blocks: list[Any] = [
        ReportTable(
            ("", "mean absolute error", "SE", "surfaces"),
            rows,
            f"Points of the scale, told by {told_by}. Where it was trained on the display signals, what it says of "
            f"{NEAREST!r}, or of a copy, comes closer than what it says of a signal it never met.",
        ),
    ]
    blocks += [ReportText(f"{item}: {why}.") for item, why in made.failed.items()]
    return facts | figures, [ReportSection("What is felt of it", blocks)]


def _nearest(asked: Any, means: Mapping[str, Any]) -> str:
    return min(means, key=lambda name: float(np.nansum((means[name] - asked) ** 2)))
