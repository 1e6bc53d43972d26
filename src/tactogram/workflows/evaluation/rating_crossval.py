"""Cross-validation of a predictor of ratings: by item, by rater, or by both at once."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, cast, get_args

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets import Ratings
from tactogram.errors import ParameterError, Remedy
from tactogram.evaluation.ratings.prediction import PredictedRatings, prediction_figure
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportTable, ReportText, write_report
from tactogram.model import Example, ImageExample, ItemRatings, Kind, Model
from tactogram.signal.io.atomic import write_text
from tactogram.training.loop import run_training
from tactogram.workflows.evaluation.classifier_crossval import CrossvalRequest, CrossvalSetup
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.rated_examples import RatingData

HeldOut = Literal["item", "rater", "both"]
ITEM_NAMES = ("item", "recording", "material")
"""Values of ``by`` that hold out items: all of a rated item's recordings are on one side."""
COLUMNS = {
    "mae": "predicted",
    "mae_sd": "sd over repetitions",
    "constant_mae": "constant guess",
    "p_against_constant": "p (Wilcoxon, items)",
    "split_half_mae": "half of the raters, other half",
    "one_rater_mae": "one rater, the others",
    "rank_correlation": "rank correlation",
}
"""Figures of a word, and their headings in tables."""
Rateable = Example | ImageExample
Part = tuple[int, frozenset[str], frozenset[str]]
"""A repetition, and the items and raters held out in one of its folds; either set may be empty."""


def crossval_ratings(request: CrossvalRequest, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Train and evaluate a predictor once per fold and return its errors with those of reference guesses.

    ``by`` is ``item`` (also ``recording``, ``material``): scores of unseen items, against the mean of all raters;
    ``rater``: known items, against the mean of raters that were not trained on; or ``both``. The parts are drawn anew
    ``repeats`` times: the spread over these is that of the drawing and of the model's seed.

    Keys of the result: ``per_word`` and ``mean`` as in `PredictedRatings.as_dict`, in points of the scale, with their
    split, recipe and data, ``folds``, ``repeats``, ``items`` and ``raters``. The folder has ``crossval.json``,
    ``words.png`` and ``report.html``.

    Raises `ParameterError` if a parameter is for classifiers, there are too few items or raters, or ``out`` cannot be
    written to.
    """
    if request.split or request.only_folds:
        raise ParameterError(
            "is for classifiers",
            parameter="split" if request.split else "only_folds",
            remedy=(Remedy("of a predictor give", "folds"), Remedy("", "repeats")),
        )
    held_out, folds, repeats = _held_out(request.by), request.folds, request.repeats
    setup = CrossvalSetup.of(request)
    store, recipe = setup.store, setup.recipe
    description = setup.description(_described(held_out, folds, repeats))
    folder = setup.folder(description)
    rated = RatingData(store, setup.facts.learns_from)
    split = rated.split(setup.index, recipe.prepare, split="all", by="recording", seed=recipe.seed)
    examples = list(rated.examples(split, "train", recipe.prepare))  # prepared once, for all folds
    items = tuple(sorted({str(e.item) for e in examples}))
    ratings = rated.ratings.select(items=items)
    parts = _all_parts(held_out, items, ratings.raters, folds, repeats=repeats, seed=recipe.seed)
    data = _RatedData(request.for_workers(), rated.kind(examples), examples, ratings)
    predictions, described_by = _predicted(setup, data, parts, held_out, folder, progress)
    figures: dict[str, Any] = {
        **predictions.as_dict(seed=recipe.seed),
        **description,
        "folds": folds,
        "repeats": repeats,
        "items": len(items),
        "raters": len(ratings.raters),
        "scale": [ratings.scale.low, ratings.scale.high],
        "model": request.model,
        "described_by": described_by,
        "data": {"name": store.name, "sha256": store.sha256, "simulated": store.simulated},
    }
    folder.mkdir(parents=True, exist_ok=True)
    figures["report"] = str(_report(folder / "report.html", predictions, figures))
    write_text(folder / "crossval.json", json.dumps(figures, indent=1) + "\n")
    return figures


def _held_out(by: str) -> HeldOut:
    held_out = "item" if by in ITEM_NAMES else by
    if held_out not in get_args(HeldOut):
        raise ParameterError.must("by", "be item, rater or both for a predictor of ratings", by)
    return cast(HeldOut, held_out)


def _all_parts(
    held_out: HeldOut, items: Sequence[str], people: Sequence[str], folds: int, *, repeats: int, seed: int
) -> list[Part]:
    if held_out != "rater" and len(items) < folds:
        raise ParameterError(f"{folds} folds need as many rated items, got {len(items)}")
    if held_out != "item" and len(people) < folds:
        raise ParameterError(f"{folds} folds need as many raters, got {len(people)}; fold by item")
    return [
        (repeat, *unseen)
        for repeat in range(repeats)
        for unseen in _parts(held_out, items, people, folds, np.random.default_rng([seed, repeat]))
    ]


def _predicted(
    setup: CrossvalSetup,
    data: _RatedData,
    parts: Sequence[Part],
    held_out: HeldOut,
    folder: Path,
    progress: ProgressCallback,
) -> tuple[PredictedRatings, str | None]:
    """Return the predictions of each part by a model trained on the rest, and a description of its features.

    A repetition is a row; where raters are held out each part is one, for all items are predicted in each.
    """
    values = setup.kept(
        partial(_part_value, data=data),
        list(enumerate(parts, start=1)),
        [[part[0], *map(sorted, part[1:])] for part in parts],
        folder,
        title="crossval",
        name=lambda part: f"part {part[0]}/{len(parts)}",
        progress=progress,
    )
    ratings = data.ratings
    rows = len(parts) if held_out == "rater" else parts[-1][0] + 1
    arrays = {
        name: np.full((rows, len(ratings.items), len(ratings.words)), np.nan)
        for name in ("scores", "constant", "truth")
    }
    index_of = {item: number for number, item in enumerate(ratings.items)}
    for number, ((repeat, unseen_items, _), value) in enumerate(zip(parts, values, strict=True)):
        row = number if held_out == "rater" else repeat
        columns = [index_of[item] for item in sorted(unseen_items or ratings.items)]
        for name, array in arrays.items():
            array[row, columns] = value[name]
    return PredictedRatings(ratings.words, ratings.items, **arrays, cube=ratings.cube), values[-1][
        "described_by"
    ]


@dataclass(frozen=True)
class _RatedData:
    """Request and data that all parts share."""

    request: CrossvalRequest
    kind: Kind
    examples: Sequence[Rateable]
    ratings: Ratings


def _part_value(numbered: tuple[int, Part], *, data: _RatedData) -> dict[str, Any]:
    """Return the scores predicted of a part's items, their truth and a constant guess, as JSON types."""
    _, (repeat, unseen_items, unseen_people) = numbered
    ratings = data.ratings
    setup = CrossvalSetup.of(data.request)
    examples = _known(data.examples, unseen_items, unseen_people)
    learner = setup.learner(data.kind, seed=setup.recipe.seed + repeat)
    learner.stages(examples)
    run_training(learner, examples, setup.recipe)
    unseen = sorted(unseen_items or ratings.items)
    people = ratings.select(raters=sorted(unseen_people)) if unseen_people else ratings
    means = {str(e.item): e.rated.means for e in examples if e.rated is not None}
    constant = ratings.scale.from_unit(np.nanmean(np.array(list(means.values())), axis=0))
    return {
        "scores": predicted_scores(learner, data.examples, unseen).tolist(),
        "truth": _rows(people, unseen).tolist(),
        "constant": np.broadcast_to(constant, (len(unseen), len(ratings.words))).tolist(),
        "described_by": learner.feature_description,
    }


def words_table(figures: Mapping[str, Any], *, caption: str = "") -> ReportTable:
    """Return a table with a row per word of `PredictedRatings.as_dict`."""
    rows = [(word, *(row[c] for c in COLUMNS)) for word, row in figures["per_word"].items()]
    rows.append(("mean", *(figures["mean"][c] for c in COLUMNS)))
    return ReportTable(
        ("word", *COLUMNS.values()), rows, caption or "Mean absolute errors, points of the scale."
    )


def predicted_scores(
    learner: Model, examples: Sequence[Rateable], items: Sequence[str]
) -> NDArray[np.float64]:
    """Return the scores predicted of each of ``items``, the mean over its examples, shape (item, word)."""
    scores: dict[str, list[list[float]]] = {item: [] for item in items}
    for example in examples:
        if str(example.item) in scores:
            stimulus = example.signal if isinstance(example, Example) else example.image
            scores[str(example.item)].append(list(learner.predict(stimulus).values()))
    return np.array([np.mean(scores[item], axis=0) for item in items])


def _parts(
    held_out: HeldOut, items: Sequence[str], people: Sequence[str], folds: int, rng: np.random.Generator
) -> list[tuple[frozenset[str], frozenset[str]]]:
    def drawn(names: Sequence[str]) -> list[frozenset[str]]:
        return [frozenset(part.tolist()) for part in np.array_split(rng.permutation(list(names)), folds)]

    if held_out == "item":
        return [(part, frozenset()) for part in drawn(items)]
    if held_out == "rater":
        return [(frozenset(), part) for part in drawn(people)]
    return list(zip(drawn(items), drawn(people), strict=True))


def _known(examples: Sequence[Rateable], items: frozenset[str], people: frozenset[str]) -> list[Any]:
    """Return the examples for training: of other items, with the scores of other people."""
    kept = [example for example in examples if str(example.item) not in items]
    if not people:
        return kept
    training = []
    for example in kept:
        rated = example.rated
        if rated is None:
            continue
        others = [n for n, name in enumerate(rated.raters) if name not in people]
        if others:
            scores = ItemRatings(rated.words, tuple(rated.raters[n] for n in others), rated.scores[others])
            training.append(replace(example, rated=scores))
    return training


def _rows(ratings: Ratings, items: Sequence[str]) -> NDArray[np.float64]:
    """Return the means of ``items``, shape (item, word), NaN where these people did not score."""
    places = {name: number for number, name in enumerate(ratings.items)}
    nothing = np.full(len(ratings.words), np.nan)
    return np.array([ratings.means[places[item]] if item in places else nothing for item in items])


def _described(held_out: HeldOut, folds: int, repeats: int) -> str:
    again = f", drawn {repeats} times" if repeats > 1 else ""
    if held_out == "item":
        return (
            f"{folds} folds by item{again}: no item is on both sides; judged against the mean of all raters"
        )
    if held_out == "rater":
        return (
            f"{folds} folds by rater{again}: known items, judged against the mean of raters that were not trained on; "
            "each fold is a repetition"
        )
    return f"{folds} folds by item and rater at once{again}: unseen items, judged by unseen raters"


def _report(path: Path, predictions: PredictedRatings, figures: Mapping[str, Any]) -> Path:
    mean, data = figures["mean"], figures["data"]
    human = (
        "There is one score per item and word: how well people agree is not known."
        if mean["split_half_mae"] is None
        else f"One half of the raters meets the other's mean to {mean['split_half_mae']:.2f}."
    )
    return write_report(
        path,
        title=f"Cross-validation: {figures['model']}",
        summary=(
            f"{figures['model']} on {data['name']}: mean absolute error {mean['mae']:.2f} on a scale of "
            f"{figures['scale'][0]:g} to {figures['scale'][1]:g}; a constant guess errs by {mean['constant_mae']:.2f}. "
            f"{human} Split: {figures['split']}."
        ),
        simulated=data["simulated"],
        sections=[
            ReportSection(
                "Words",
                [
                    words_table(figures),
                    ReportFigure(
                        prediction_figure(
                            predictions, figures, title="Simulated raters" if data["simulated"] else ""
                        ),
                        "Bars: standard deviation over repetitions. Right: each dot an item and word.",
                        file="words.png",
                    ),
                ],
            ),
            ReportSection("Recipe", [ReportText(json.dumps(figures["recipe"]))]),
        ],
    )
