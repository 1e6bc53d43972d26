"""Cross-validation of a predictor of ratings: by item, by rater, or both kept apart at once."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, cast, get_args

import numpy as np
from numpy.typing import NDArray

from tactogram import models
from tactogram.datasets import Ratings, open_store
from tactogram.errors import ParameterError
from tactogram.evaluation.ratings.figures import prediction_figure
from tactogram.evaluation.ratings.prediction import PredictedRatings
from tactogram.evaluation.report import (
    ReportFigure,
    ReportSection,
    ReportTable,
    ReportText,
    save_figure,
    write_report,
)
from tactogram.model import Example, ImageExample, ItemRatings, Kind, Predictor, feature_description
from tactogram.recipe import Recipe, run_id
from tactogram.signal.io.atomic import write_text
from tactogram.signal.io.writable import check_writable
from tactogram.training.device import make_fabric
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.plan import select
from tactogram.workflows.training.rated_examples import RatingData
from tactogram.workflows.training.train import run_training

HeldOut = Literal["item", "rater", "both"]
ITEM_NAMES = ("item", "recording", "material")
"""What ``--by`` may be called where items are kept apart: all of a rated item's recordings go together."""
COLUMNS = {
    "mae": "predicted",
    "mae_sd": "sd over repetitions",
    "constant_mae": "constant guess",
    "p_against_constant": "p (Wilcoxon, items)",
    "split_half_mae": "half of the raters, other half",
    "one_rater_mae": "one rater, the others",
    "rank_correlation": "rank correlation",
}
"""Figures of a word, and what tables call them."""
Rateable = Example | ImageExample
Part = tuple[int, frozenset[str], frozenset[str]]
"""A repetition, and the items and raters that are kept apart in a fold of it; none where the set is empty."""


def crossval_ratings(
    model: str,
    data: Path | str,
    *,
    folds: int = 10,
    repeats: int = 3,
    by: str = "item",
    where: Mapping[str, str] | None = None,
    recipe: str = "quick",
    changes: Mapping[str, Any] | None = None,
    out: Path | str | None = None,
    accelerator: str = "auto",
    model_folders: Sequence[Path] = (),
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Train and judge a predictor once per fold and return its errors beside what they are to be held against.

    Parameters
    ----------
    model, data, where, recipe, changes : see `tactogram.workflows.training.train.train`
    folds : int
        Parts of the items, or of the raters; at most as many as there are.
    repeats : int
        How often the parts are drawn anew: spread over these is that of the drawing and of the model's seed.
    by : {"item", "rater", "both"}
        What is kept apart. ``item`` (also ``recording``, ``material``): scores of unseen items, against the mean of all
        raters. ``rater``: known items, against the mean of people whose scores were not trained on. ``both``.
    out : path, optional
        Folder for ``crossval.json``, ``words.png`` and ``report.html``; by default under ``runs``.

    Returns
    -------
    dict
        ``per_word`` and ``mean`` as `PredictedRatings.as_dict` gives them, in points of the scale, with the split,
        recipe and
        data that they are of, ``folds``, ``repeats``, ``items`` and ``raters``.

    Raises
    ------
    ParameterError
        If the model is no predictor, there are too few items or raters, or ``out`` cannot be written to.
    """
    kept = _kept_apart(by)
    if repeats < 1 or folds < 2:
        raise ParameterError(f"--folds must be at least 2 and --repeats 1, got {folds} and {repeats}")
    store = open_store(data)
    facts = models.find(model, model_folders)
    if facts.task != "prediction":
        raise ParameterError(f"{model} is no predictor of ratings")
    chosen = Recipe.load(facts.recipe(recipe), changes=changes)
    config = facts.config(chosen.config)
    asked: dict[str, Any] = {
        "recipe": chosen.resolved(config),
        "split": _described(kept, folds, repeats),
        "where": dict(where or {}),
    }
    identity = run_id(asked["recipe"] | {"split": asked["split"], "where": asked["where"]}, store.sha256)
    folder = Path(out) if out else Path("runs") / f"crossval-{model}-{Path(recipe).stem}-{identity}"
    check_writable(folder, folder=True)

    rated = RatingData(store, facts.learns_from)
    index = select(store.index, where) if len(store) else []
    split = rated.split(index, chosen.prepare, split="all", by="recording", seed=chosen.seed)
    examples = list(rated.examples(split, "train", chosen.prepare))  # prepared once, for all folds
    items = tuple(sorted({str(e.item) for e in examples}))
    ratings = rated.ratings.select(items=items)
    trainer = _Trainer(facts, config, rated.kind(examples), chosen, accelerator)
    parts = _all_parts(kept, items, ratings.raters, folds, repeats=repeats, seed=chosen.seed)
    found = _predicted(trainer.trained, examples, ratings, parts, kept, progress)
    figures: dict[str, Any] = {
        **found.as_dict(seed=chosen.seed),
        **asked,
        "folds": folds,
        "repeats": repeats,
        "items": len(items),
        "raters": len(ratings.raters),
        "scale": [ratings.scale.low, ratings.scale.high],
        "model": model,
        "described_by": trainer.described_by,
        "data": {"name": store.name, "sha256": store.sha256, "simulated": store.simulated},
    }
    folder.mkdir(parents=True, exist_ok=True)
    title = "Simulated raters" if store.simulated else ""
    save_figure(folder / "words.png", prediction_figure(found, figures, title=title))
    figures["report"] = str(_report(folder / "report.html", found, figures))
    write_text(folder / "crossval.json", json.dumps(figures, indent=1) + "\n")
    return figures


@dataclass
class _Trainer:
    """Trains a predictor anew on whatever is known in a part."""

    facts: models.ModelInfo
    config: Any
    kind: Kind
    recipe: Recipe
    accelerator: str
    described_by: str | None = None
    """What the last one goes by, where it says so."""

    def trained(self, known: Sequence[Any], repeat: int) -> Predictor:
        """Return a predictor that learned from ``known``; each repetition has a seed of its own."""
        learner = self.facts.build(self.config, self.kind, seed=self.recipe.seed + repeat)
        learner.setup(make_fabric(self.recipe.training, accelerator=self.accelerator))
        learner.stages(known)
        run_training(learner, known, self.recipe)
        if not isinstance(learner, Predictor):
            raise ParameterError(f"{self.facts.name} is no predictor of ratings")
        self.described_by = feature_description(learner)
        return learner


def _kept_apart(by: str) -> HeldOut:
    kept = "item" if by in ITEM_NAMES else by
    if kept not in get_args(HeldOut):
        raise ParameterError(f"--by must be item, rater or both for a predictor of ratings, got {by!r}")
    return cast(HeldOut, kept)


def _all_parts(
    kept: HeldOut, items: Sequence[str], people: Sequence[str], folds: int, *, repeats: int, seed: int
) -> list[Part]:
    """Return what is kept apart in each fold of each repetition."""
    if kept != "rater" and len(items) < folds:
        raise ParameterError(f"--folds {folds} needs as many rated items, got {len(items)}")
    if kept != "item" and len(people) < folds:
        raise ParameterError(f"--folds {folds} needs as many raters, got {len(people)}; use --by item")
    return [
        (repeat, *unseen)
        for repeat in range(repeats)
        for unseen in _parts(kept, items, people, folds, np.random.default_rng([seed, repeat]))
    ]


def _predicted(
    trained: Callable[[Sequence[Any], int], Predictor],
    examples: Sequence[Rateable],
    ratings: Ratings,
    parts: Sequence[Part],
    kept: HeldOut,
    progress: ProgressCallback,
) -> PredictedRatings:
    """Return what was predicted of each part by what the rest trained.

    A repetition is a row; where raters are kept apart each part is one, for all items are predicted in each.
    """
    items = ratings.items
    rows = len(parts) if kept == "rater" else parts[-1][0] + 1
    scores, truth, constant = (np.full((rows, len(items), len(ratings.words)), np.nan) for _ in range(3))
    place = {item: number for number, item in enumerate(items)}
    for number, (repeat, unseen_items, unseen_people) in enumerate(parts):
        progress("crossval", number + 1, len(parts))
        known = _known(examples, unseen_items, unseen_people)
        learner = trained(known, repeat)
        row = number if kept == "rater" else repeat
        judged = sorted(unseen_items or items)
        at = [place[item] for item in judged]
        judges = ratings.select(raters=sorted(unseen_people)) if unseen_people else ratings
        scores[row, at] = predicted_scores(learner, examples, judged)
        truth[row, at] = _rows(judges, judged)
        means = {str(e.item): e.rated.means for e in known if e.rated is not None}
        constant[row, at] = ratings.scale.from_unit(np.nanmean(np.array(list(means.values())), axis=0))
    return PredictedRatings(ratings.words, items, scores, constant, truth, ratings.cube)


def words_table(figures: Mapping[str, Any], *, caption: str = "") -> ReportTable:
    """Return the table of words that `PredictedRatings.as_dict` gave."""
    rows = [(word, *(row[c] for c in COLUMNS)) for word, row in figures["per_word"].items()]
    rows.append(("mean", *(figures["mean"][c] for c in COLUMNS)))
    return ReportTable(
        ("word", *COLUMNS.values()), rows, caption or "Mean absolute errors, points of the scale."
    )


def predicted_scores(
    learner: Predictor, examples: Sequence[Rateable], items: Sequence[str]
) -> NDArray[np.float64]:
    """Return the scores predicted of each of ``items``, the mean over its examples, shape (item, word)."""
    found: dict[str, list[list[float]]] = {item: [] for item in items}
    for example in examples:
        if str(example.item) in found:
            given = example.signal if isinstance(example, Example) else example.image
            found[str(example.item)].append(list(learner.predict(given).values()))
    return np.array([np.mean(found[item], axis=0) for item in items])


def _parts(
    kept: HeldOut, items: Sequence[str], people: Sequence[str], folds: int, rng: np.random.Generator
) -> list[tuple[frozenset[str], frozenset[str]]]:
    """Return what is kept apart in each fold: items (empty: none) and raters (empty: none)."""

    def drawn(names: Sequence[str]) -> list[frozenset[str]]:
        return [frozenset(part.tolist()) for part in np.array_split(rng.permutation(list(names)), folds)]

    if kept == "item":
        return [(part, frozenset()) for part in drawn(items)]
    if kept == "rater":
        return [(frozenset(), part) for part in drawn(people)]
    return list(zip(drawn(items), drawn(people), strict=True))


def _known(examples: Sequence[Rateable], items: frozenset[str], people: frozenset[str]) -> list[Any]:
    """Return what may be trained on: other items, and of these what other people said."""
    kept = [example for example in examples if str(example.item) not in items]
    if not people:
        return kept
    found = []
    for example in kept:
        said = example.rated
        who = [n for n, name in enumerate(said.raters) if name not in people] if said is not None else []
        if said is not None and who:
            some = ItemRatings(said.words, tuple(said.raters[n] for n in who), said.scores[who])
            found.append(replace(example, rated=some))
    return found


def _rows(ratings: Ratings, items: Sequence[str]) -> NDArray[np.float64]:
    """Return the means of ``items``, shape (item, word), NaN where these people did not score."""
    places = {name: number for number, name in enumerate(ratings.items)}
    nothing = np.full(len(ratings.words), np.nan)
    return np.array([ratings.means[places[item]] if item in places else nothing for item in items])


def _described(kept: HeldOut, folds: int, repeats: int) -> str:
    again = f", drawn {repeats} times" if repeats > 1 else ""
    if kept == "item":
        return (
            f"{folds} folds by item{again}: no item is on both sides; judged against the mean of all raters"
        )
    if kept == "rater":
        return (
            f"{folds} folds by rater{again}: known items, judged against the mean of raters that were not trained on; "
            "each fold is a repetition"
        )
    return f"{folds} folds by item and rater at once{again}: unseen items, judged by unseen raters"


def _report(path: Path, found: PredictedRatings, figures: Mapping[str, Any]) -> Path:
    mean, data = figures["mean"], figures["data"]
    human = (
        "There is one score per item and word: how well people agree cannot be told."
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
                        prediction_figure(found, figures),
                        "Bars: standard deviation over repetitions. Right: each dot an item and word.",
                    ),
                ],
            ),
            ReportSection("Recipe", [ReportText(json.dumps(figures["recipe"]))]),
        ],
    )
