"""Evaluation by ratings: of predictors, and of generators conditioned on words."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings, Scale, Split, Store, item_of, open_store
from tactogram.errors import LeakError, ParameterError, Remedy
from tactogram.evaluation.ratings.prediction import PredictedRatings, prediction_figure
from tactogram.evaluation.ratings.reproduction import constant_error, reproduction
from tactogram.evaluation.report import ReportFigure, ReportSection, save_figure
from tactogram.signal import Image, Signal
from tactogram.signal.io.atomic import write_text
from tactogram.statistics.figures import error_figure
from tactogram.workflows.evaluation.rating_crossval import Rateable, predicted_scores, words_table
from tactogram.workflows.training.loaded_run import LoadedRun, load_run, test_part
from tactogram.workflows.training.rated_examples import RatingData

Floats = NDArray[np.float64]
MODEL = "rater model"
"""Name of a rater model among raters."""


def evaluate_predictor(
    loaded: LoadedRun, *, data: Path | str | None = None
) -> tuple[dict[str, Any], list[ReportSection]]:
    """Return the errors of a predictor on items that it was not trained on, with those of a constant guess and people.

    The items are those of the store ``data``, by default of the run's test part. The figures are ``data`` and those of
    `PredictedRatings.as_dict`: ``per_word`` and ``mean``.

    Raises `LeakError` if a recording or an image of ``data`` was trained on, whatever its item's name; `ParameterError`
    if there are no rated items, or they were rated in other words or on another scale.
    """
    store, split, described = _test_part(loaded, data)
    rated = RatingData(store, loaded.facts.learns_from)
    ratings = rated.ratings
    kind = loaded.any_kind
    if ratings.words != kind.words or (ratings.scale.low, ratings.scale.high) != kind.scale:
        raise ParameterError(
            f"{store.path}: must be rated in {', '.join(kind.words)} on the run's scale {kind.scale}; "
            f"got {', '.join(ratings.words)} on {ratings.scale.low:g} to {ratings.scale.high:g}"
        )
    prepare = loaded.as_trained if not rated.of_images else loaded.recipe.prepare
    examples: list[Rateable] = list(rated.examples(split, "test", prepare))
    if not examples:
        raise ParameterError(
            loaded.run.name, "kept no rated items for testing", remedy=Remedy("give", "data")
        )
    items = sorted({str(example.item) for example in examples})
    held = ratings.select(items=items)
    guess = _trained_mean(loaded)
    shape = (1, *held.means.shape)
    predictions = PredictedRatings(
        ratings.words,
        items,
        predicted_scores(loaded.predictor, examples, items)[None],
        np.broadcast_to(guess, shape),
        held.means[None],
        held.cube,
    )
    figures = predictions.as_dict()
    facts = loaded.facts_on(store, f"{len(items)} rated items {described}")
    facts["described_by"] = loaded.model.feature_description
    caption = "Mean absolute errors, points of the scale. " + ("Simulated raters." if store.simulated else "")
    picture = ReportFigure(prediction_figure(predictions, figures), "Right: each dot an item and word.")
    return facts | figures, [ReportSection("Words", [words_table(figures, caption=caption), picture])]


def predicted_ratings(run: Path | str | LoadedRun, given: Mapping[str, Signal | Image]) -> Ratings:
    """Return the scores of a rater model for ``given``, as ratings of one rater named `MODEL`.

    Raises `ParameterError` if the run is no predictor of scores.
    """
    loaded = run if isinstance(run, LoadedRun) else load_run(run)
    if loaded.facts.task != "prediction" or loaded.any_kind.scale is None:
        raise ParameterError(f"{loaded.run.name}: {loaded.facts.name} is not a predictor of scores")
    rows = []
    for item, stimulus in given.items():
        prepared = loaded.prepare(stimulus) if isinstance(stimulus, Signal) else stimulus
        rows += [(item, word, score) for word, score in loaded.model.predict(prepared).items()]
    low, high = loaded.any_kind.scale
    return Ratings(
        (MODEL,) * len(rows),
        tuple(item for item, _, _ in rows),
        tuple(word for _, word, _ in rows),
        np.array([score for _, _, score in rows]),
        Scale("predicted", low, high),
        words=loaded.any_kind.words,
    )


def evaluate_reproduction(
    ratings: Ratings,
    targets: Mapping[str, Sequence[float]],
    *,
    conditions: Sequence[str],
    told_by: str,
    out: Path,
    beside: Mapping[str, float] | None = None,
    first: str = "",
) -> dict[str, Any]:
    """Return and draw the rating errors of generated signals, as Fig. 7 of Hatori & Takemura.

    The ratings, of people, simulated people or a rater model (``told_by``), are of items ``CONDITION/TARGET``; targets
    have mean scores in the order of the ratings' words. ``beside`` are errors drawn as lines, of a constant guess or of
    people among themselves. Brackets mark p < 0.01 as printed against the condition ``first``, by default the first
    one. ``out`` is the PNG figure, with a JSON file of the result next to it: `Reproduction.as_dict`, ``beside`` and
    ``figure``.
    """
    errors = reproduction(
        ratings,
        {name: np.asarray(row, np.float64) for name, row in targets.items()},
        conditions=conditions,
        told_by=told_by,
    )
    figures = errors.as_dict()
    lines = {
        "constant guess, without a rater's noise": constant_error(
            {n: np.asarray(r) for n, r in targets.items()}
        )
    } | dict(beside or {})
    figures["beside"] = lines
    rows = {name: (row["mae"], row["se"] or 0.0) for name, row in figures["conditions"].items()}
    marked = [
        (pair["first"], pair["second"], "*")
        for pair in figures["tests"]["as_printed"] or ()
        if (first or next(iter(rows))) in (pair["first"], pair["second"])
        and pair["p"] is not None
        and pair["p"] < 0.01
    ]
    count = max(row["n"] for row in figures["conditions"].values())
    title = f"Rated by {told_by}\nn = {count:,} answers, mean ± SE, *: p < 0.01 (Student's t)"
    save_figure(out, error_figure(rows, marked=marked, lines=lines, title=title))
    figures["figure"] = str(out)
    write_text(out.with_suffix(".json"), json.dumps(figures, indent=1) + "\n")
    return figures


def _test_part(loaded: LoadedRun, data: Path | str | None) -> tuple[Store, Split, str]:
    """Return the store, a split with the test part, and a description of that."""
    if data is None:
        store, split = test_part(loaded.run)
        return store, split, "held out"
    store = open_store(data)
    rated = RatingData(store, loaded.facts.learns_from)
    whole = rated.split(
        store.index if len(store) else [], loaded.recipe.prepare, split="all", by="recording", seed=0
    )
    known = Split.load(loaded.run.folder / "split.json")
    trained = {s.id for s in (*known.train, *known.validation)}
    trained |= {r.key for part in ("train", "validation") for r in known.photographs.get(part, ())}
    held = {s.id for s in whole.train} | {r.key for r in whole.photographs.get("train", ())}
    both = sorted(held & trained)
    if both:
        raise LeakError(
            data,
            f"{len(both)} of its {len(held)} rated recordings or images were trained on (first: {both[0]})",
            remedy=(Remedy("evaluate on others"), Remedy("for the run's own test part omit", "data")),
        )
    photographs = {"test": whole.photographs["train"]} if whole.photographs else {}
    moved = Split((), (), whole.train, by=whole.by, seed=whole.seed, photographs=photographs)
    return store, moved, "of another data set"


def _trained_mean(loaded: LoadedRun) -> Floats:
    """Return the mean scores over the items that a run was trained on, shape (word,)."""
    store, split = test_part(loaded.run)
    rated = RatingData(store, loaded.facts.learns_from)
    items = {str(item_of(store.info(segment.id))) for segment in split.train}
    if rated.of_images:
        keys = {region.key for region in split.photographs["train"]}
        items = {item for item, held in store.photographs_by_material.items() if keys & set(held)}
    means = rated.ratings.select(items=sorted(items)).means
    return np.asarray(np.nanmean(means, axis=0))
