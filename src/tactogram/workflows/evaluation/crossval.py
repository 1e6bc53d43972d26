"""Cross-validation of a classifier: by recording wherever that is possible, never by window."""

from __future__ import annotations

import json
import operator
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial, reduce
from pathlib import Path
from typing import Any

from tactogram import models
from tactogram.datasets import (
    Examples,
    Label,
    RecordingInfo,
    Split,
    Store,
    contiguous_blocks,
    kfold,
    open_store,
    signal_kind,
)
from tactogram.datasets.scratch import scratch
from tactogram.datasets.splits.split import By
from tactogram.errors import ParameterError
from tactogram.evaluation.classification import ClassificationResult, evaluate_classifier
from tactogram.evaluation.figures import confusion_figure
from tactogram.evaluation.report import (
    ReportFigure,
    ReportSection,
    ReportTable,
    ReportText,
    save_figure,
    write_report,
)
from tactogram.model import Classifier, window_of
from tactogram.recipe import Recipe, run_id
from tactogram.signal.io.atomic import write_text
from tactogram.signal.io.writable import check_writable
from tactogram.training.device import make_fabric
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.plan import labelled, make_split, select
from tactogram.workflows.training.train import run_training

CONFUSION = "Share of the windows of each true class (row) that were answered so (column), as in Table I of the paper."


def crossval(
    model: str,
    data: Path | str,
    *,
    folds: int = 10,
    only_folds: int | None = None,
    split: str = "",
    by: By = "recording",
    label: Label = "material",
    where: Mapping[str, str] | None = None,
    recipe: str = "quick",
    changes: Mapping[str, Any] | None = None,
    out: Path | str | None = None,
    accelerator: str = "auto",
    model_folders: Sequence[Path] = (),
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Train and judge ``model`` once per fold and return the figures over all of them.

    Folds are drawn by recording where every class has at least as many recordings as there are folds. Where
    it has fewer, as in the three long takes of Saga et al., each recording is divided into ``folds``
    contiguous blocks with a gap of one window between training and test: the closest fair reading of their
    "divided into ten parts".

    Parameters
    ----------
    model, data, by, label, where, recipe, changes : see `tactogram.workflows.training.train.train`
    folds : int
    only_folds : int, optional
        Train and judge only the first so many folds; said in the result.
    split : str
        ``last=N`` tests once on the last N recordings of each material instead of in folds.
    out : path, optional
        Folder for ``crossval.json``, ``confusion.png`` and ``report.html``; by default under ``runs``.

    Returns
    -------
    dict
        ``window_accuracy``, ``recording_accuracy`` and what `ClassificationResult.as_dict` gives, with the
        split, recipe and data that they are of, and ``per_fold``.

    Raises
    ------
    ParameterError
        If the model is no classifier, there are too few recordings for the folds, or ``out`` cannot be
        written to.
    """
    if only_folds is not None and only_folds < 1:
        raise ParameterError(f"--only-folds must be at least 1, got {only_folds}")
    facts = models.find(model, model_folders)
    if facts.task != "classification":
        raise ParameterError(
            f"crossval is for classifiers and predictors of ratings; {model} is for {facts.task}: train and evaluate it"
        )
    store = open_store(data)
    chosen = Recipe.load(facts.recipe(recipe), changes=changes)
    config = facts.config(chosen.config)
    index = select(store.index, where)
    splits, described = _splits(store, index, chosen, config, folds=folds, split=split, by=by, label=label)
    run_splits = splits[:only_folds] if only_folds else splits
    if len(run_splits) < len(splits):
        described += f"; only {len(run_splits)} of the {len(splits)} folds were run"
    resolved, kept = chosen.resolved(config), dict(where or {})
    identity = run_id(resolved | {"split": described, "label": label, "where": kept}, store.sha256)
    folder = Path(out) if out else Path("runs") / f"crossval-{model}-{Path(recipe).stem}-{identity}"
    check_writable(folder, folder=True)

    results, rate = _judged_folds(
        facts, store, chosen, config, run_splits, label=label, accelerator=accelerator, progress=progress
    )
    result = reduce(operator.add, results)

    figures: dict[str, Any] = {
        **result.as_dict(),
        "per_fold": [
            {"window_accuracy": r.window_accuracy, "recording_accuracy": r.recording_accuracy}
            for r in results
        ],
        "folds": len(results),
        "split": described,
        "model": model,
        "recipe": resolved,
        "rate_hz": rate,
        "data": {"name": store.name, "sha256": store.sha256, "simulated": store.simulated},
        "label": label,
        "where": kept,
    }
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(folder / "confusion.png", confusion_figure(result.windows, result.materials))
    figures["report"] = str(_report(folder / "report.html", figures, result))
    write_text(folder / "crossval.json", json.dumps(figures, indent=1) + "\n")
    return figures


def _judged_folds(
    facts: models.ModelInfo,
    store: Store,
    recipe: Recipe,
    config: Any,
    splits: Sequence[Split],
    *,
    label: Label,
    accelerator: str,
    progress: ProgressCallback,
) -> tuple[list[ClassificationResult], float]:
    """Return what classifiers trained on each split make of its test part, and the rate they were trained at, Hz."""
    results: list[ClassificationResult] = []
    with scratch() as prepared:
        cut = partial(Examples, store, prepare=recipe.prepare, label=label, cache_dir=prepared)
        for number, parts in enumerate(splits, start=1):
            examples = cut((*parts.train, *parts.validation))
            examples.prepare_all(progress=partial(progress, f"prepare {number}/{len(splits)}"))
            kind = signal_kind(examples, simulated=store.simulated)
            learner = facts.build(config, kind, seed=recipe.seed)
            if not isinstance(learner, Classifier):
                raise ParameterError(f"{facts.name} is not a classifier: crossval needs one")
            learner.setup(make_fabric(recipe.training, accelerator=accelerator))
            task = f"fold {number}/{len(splits)} " if len(splits) > 1 else ""
            run_training(learner, examples, recipe, task=task, progress=progress)
            results.append(evaluate_classifier(learner, cut(parts.test)))
    return results, kind.rate


def _splits(
    store: Store,
    index: Sequence[RecordingInfo],
    recipe: Recipe,
    config: Any,
    *,
    folds: int,
    split: str,
    by: By,
    label: Label,
) -> tuple[list[Split], str]:
    """Return the splits of a cross-validation and a sentence that says how they were made."""
    if split == "all":
        raise ParameterError("--split all keeps nothing for testing; give last=N, or --folds")
    if split:
        parts = make_split(index, split=split, by=by, seed=recipe.seed, label=label)
        return [parts], f"tested on the {split.replace('=', ' ')} recordings of each material, by recording"
    if folds < 2:
        raise ParameterError(f"--folds must be at least 2, got {folds}")
    index = labelled(index, label)
    scarcest, fewest = min(Counter(info.material for info in index).items(), key=lambda pair: pair[1])
    if by != "recording" or fewest >= folds:
        return kfold(index, folds, by=by, seed=recipe.seed), f"{folds} folds by {by}"
    stream = recipe.prepare.stream_of(tuple(store.streams))
    seconds = {info.id: store.length(info.id, stream) / store.rate(info.id, stream) for info in index}
    rate = recipe.prepare.rate_of(store.rate(index[0].id, stream))
    gap = window_of(config) / rate
    if min(seconds.values()) / folds < 3 * gap:
        instead = (
            f"use --folds {fewest}" if fewest >= 2 else "record more of it, or leave it out with --where"
        )
        raise ParameterError(
            f"--folds {folds} needs as many recordings of every class, or recordings long enough to divide; "
            f"{scarcest} has {fewest}: {instead}"
        )
    between = f", {gap:.2g} s (one window) left out between" if gap else ""
    described = f"{folds} contiguous blocks of each recording{between}; each block counts as a recording"
    return contiguous_blocks(index, seconds, blocks=folds, gap_s=gap), described


def _report(path: Path, figures: Mapping[str, Any], result: ClassificationResult) -> Path:
    low, high = result.recording_interval
    data = figures["data"]
    summary = (
        f"{figures['model']} on {data['name']}: {100 * result.recording_accuracy:.1f} % of recordings "
        f"(95 % interval {100 * low:.1f}–{100 * high:.1f} %) and {100 * result.window_accuracy:.1f} % of "
        f"windows classified correctly; chance is {100 * figures['chance']:.1f} %. Split: {figures['split']}."
    )
    per_material = [
        (name, row["window_accuracy"], row["recording_accuracy"], row["recordings"])
        for name, row in figures["per_material"].items()
    ]
    per_fold = [
        (number, fold["window_accuracy"], fold["recording_accuracy"])
        for number, fold in enumerate(figures["per_fold"], start=1)
    ]
    return write_report(
        path,
        title=f"Cross-validation: {figures['model']}",
        summary=summary,
        simulated=data["simulated"],
        sections=[
            ReportSection(
                "Confusion", [ReportFigure(confusion_figure(result.windows, result.materials), CONFUSION)]
            ),
            ReportSection(
                "Classes and folds",
                [
                    ReportTable(
                        ("class", "window accuracy", "recording accuracy", "recordings"), per_material
                    ),
                    ReportTable(("fold", "window accuracy", "recording accuracy"), per_fold),
                ],
            ),
            ReportSection("Recipe", [ReportText(json.dumps(figures["recipe"]))]),
        ],
    )
