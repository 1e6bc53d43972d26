"""Cross-validation of a classifier: by recording wherever that is possible, never by window."""

from __future__ import annotations

import json
import operator
import shutil
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial, reduce
from operator import attrgetter
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np

from tactogram import models
from tactogram.datasets import Examples, RecordingInfo, Split, Store, kfold, open_store, signal_kind
from tactogram.datasets.examples import cores
from tactogram.datasets.scratch import scratch
from tactogram.datasets.splits.split import By
from tactogram.errors import ParameterError, Remedy
from tactogram.evaluation.classification import ClassificationResult, evaluate_classifier
from tactogram.evaluation.figures import confusion_figure
from tactogram.evaluation.report import ReportFigure, ReportSection, ReportTable, ReportText, write_report
from tactogram.model import Kind, Model, ModelConfig
from tactogram.recipe import Recipe, run_id
from tactogram.signal.io.atomic import check_writable, write_text
from tactogram.training.device import make_fabric
from tactogram.training.loop import run_training
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.plan import TrainingRequest, block_splits, labelled, make_split, select
from tactogram.workflows.workers.tasks import kept_values

T = TypeVar("T")
CONFUSION = "Share of the windows of each true class (row) that were answered so (column), as in Table I of the paper."


@dataclass(frozen=True)
class CrossvalRequest(TrainingRequest):
    """A cross-validation, as `tactogram.crossval` takes it."""

    out: Path | str | None = None
    folds: int = 10
    only_folds: int | None = None
    repeats: int = 3
    on: str = ""
    processes: int | None = None


def crossval_classifier(request: CrossvalRequest, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Train and evaluate a classifier once per fold and return the figures over all of them.

    Folds are drawn by recording where every class has at least as many recordings as there are folds. Where
    it has fewer, as in the three long takes of Saga et al., each recording is divided into ``folds``
    contiguous blocks with a gap of one window between training and test: the closest fair reading of their
    "divided into ten parts". With ``split`` ``last=N`` there is one test, on the last N recordings of each material.
    Each fold runs on one thread, so that ``on`` and ``processes`` change no figure; one that is done is kept in the
    folder until all are, and a cross-validation that was killed goes on when it is started again.

    Returns
    -------
    dict
        As of `tactogram.crossval`. The folder has ``crossval.json``, ``confusion.png`` and ``report.html``.

    Raises
    ------
    ParameterError
        If there are too few recordings for the folds, or ``out`` cannot be written to.
    """
    setup = CrossvalSetup.of(request)
    splits, described = _splits(setup)
    run_splits = splits[: request.only_folds] if request.only_folds else splits
    if len(run_splits) < len(splits):
        described += f"; only {len(run_splits)} of the {len(splits)} folds were run"
    description = setup.description(described, label=request.label)
    folder = setup.folder(description)
    results, rate = _evaluated_folds(setup, run_splits, folder, progress)
    result = reduce(operator.add, results)
    store = setup.store
    figures: dict[str, Any] = {
        **result.as_dict(),
        "per_fold": [
            {"window_accuracy": r.window_accuracy, "recording_accuracy": r.recording_accuracy}
            for r in results
        ],
        "folds": len(results),
        **description,
        "model": request.model,
        "rate_hz": rate,
        "data": {"name": store.name, "sha256": store.sha256, "simulated": store.simulated},
    }
    folder.mkdir(parents=True, exist_ok=True)
    figures["report"] = str(_report(folder / "report.html", figures, result))
    write_text(folder / "crossval.json", json.dumps(figures, indent=1) + "\n")
    return figures


@dataclass(frozen=True)
class _Fold:
    request: CrossvalRequest
    parts: Split
    number: int
    total: int
    prepared: Path
    """Folder of prepared signals, for those on this machine."""

    @property
    def name(self) -> str:
        return f"fold {self.number}/{self.total}"


def _evaluated_folds(
    setup: CrossvalSetup, splits: Sequence[Split], folder: Path, progress: ProgressCallback
) -> tuple[list[ClassificationResult], float]:
    """Return the results of classifiers trained and tested on each split, and their rate, Hz."""
    sent = setup.request.for_workers()
    with scratch() as prepared:
        folds = [_Fold(sent, parts, n, len(splits), prepared) for n, parts in enumerate(splits, start=1)]
        alone = setup.processes(len(splits)) == 1 and not setup.request.on
        values = setup.kept(
            partial(_fold_value, progress=progress) if alone else _fold_value,
            folds,
            [parts.as_dict() for parts in splits],
            folder,
            title="cross-validation",
            name=attrgetter("name"),
            progress=silent if len(folds) == 1 else progress,
        )
    names = ("windows", "recordings", "candidates")
    counts = [{name: np.array(value[name], np.int64) for name in names} for value in values]
    materials = [tuple(value["materials"]) for value in values]
    results = [ClassificationResult(of, **fold) for of, fold in zip(materials, counts, strict=True)]
    return results, values[-1]["rate_hz"]


def _fold_value(fold: _Fold, progress: ProgressCallback = silent) -> dict[str, Any]:
    """Return the counts of a classifier that is trained and tested on a split, as JSON types."""
    setup = CrossvalSetup.of(fold.request)
    recipe, store, parts = setup.recipe, setup.store, fold.parts
    cache = fold.prepared if fold.prepared.is_dir() else None
    cut = partial(Examples, store, prepare=recipe.prepare, label=fold.request.label, cache_dir=cache)
    examples = cut((*parts.train, *parts.validation))
    examples.prepare_all(progress=partial(progress, f"prepare {fold.number}/{fold.total}"))
    kind = signal_kind(examples, simulated=store.simulated)
    learner = setup.learner(kind, seed=recipe.seed)
    task = f"{fold.name} " if fold.total > 1 else ""
    run_training(learner, examples, recipe, task=task, progress=progress)
    result = evaluate_classifier(learner, cut(parts.test))
    return {
        "materials": list(result.materials),
        "windows": result.windows.tolist(),
        "recordings": result.recordings.tolist(),
        "candidates": result.candidates.tolist(),
        "rate_hz": kind.rate,
    }


def _splits(setup: CrossvalSetup) -> tuple[list[Split], str]:
    """Return the splits of a cross-validation and a sentence that describes them."""
    request, recipe, store = setup.request, setup.recipe, setup.store
    folds, split, label, by = request.folds, request.split, request.label, cast(By, request.by)
    if split == "all":
        folded = Remedy("use last=N, or give", "folds")
        raise ParameterError("all keeps nothing for testing", parameter="split", remedy=folded)
    if split == "blocks":
        folded = Remedy("to test on every block, give", "folds")
        raise ParameterError("blocks is for one training", parameter="split", remedy=folded)
    if split:
        parts = make_split(setup.index, split=split, by=by, seed=recipe.seed, label=label)
        return [parts], f"tested on the {split.replace('=', ' ')} recordings of each material, by recording"
    index = labelled(setup.index, label)
    scarcest, fewest = min(Counter(info.material for info in index).items(), key=lambda pair: pair[1])
    if by != "recording" or fewest >= folds:
        return kfold(index, folds, by=by, seed=recipe.seed), f"{folds} folds by {by}"
    scarce = f"{scarcest} has {fewest} of the {folds} recordings that folds of recordings need"
    more = Remedy(f"{scarce}: record more of it, or exclude it with", "where")
    remedy = Remedy(f"{scarce}: use {fewest} folds") if fewest >= 2 else more
    splits = block_splits(store, index, recipe, setup.config, blocks=folds, remedy=remedy)
    between = f", {splits[0].gap_s:.2g} s (one window) left out between" if splits[0].gap_s else ""
    return splits, f"{folds} contiguous blocks of each recording{between}; each block counts as a recording"


def _report(path: Path, figures: Mapping[str, Any], result: ClassificationResult) -> Path:
    low, high = result.recording_interval
    data = figures["data"]
    title = "Simulated data" if data["simulated"] else ""
    confusion = confusion_figure(result.windows, result.materials, title=title)
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
            ReportSection("Confusion", [ReportFigure(confusion, CONFUSION, file="confusion.png")]),
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


@dataclass(frozen=True)
class CrossvalSetup:
    """Model, recipe and recordings of a cross-validation."""

    request: CrossvalRequest
    store: Store
    facts: models.ModelInfo
    recipe: Recipe
    config: ModelConfig
    index: Sequence[RecordingInfo]

    @classmethod
    def of(cls, request: CrossvalRequest) -> CrossvalSetup:
        """Open the data and the model."""
        facts = models.find(request.model, request.model_folders)
        store = open_store(request.data)
        recipe = Recipe.load(facts.recipe(request.recipe), changes=request.recipe_changes)
        index = select(store.index, request.where) if len(store) else []
        return cls(request, store, facts, recipe, facts.config(recipe.config), index)

    def description(self, split: str, **more: Any) -> dict[str, Any]:
        """Return the facts that all results share, and by which `folder` is named."""
        where = dict(self.request.where or {})
        return {"recipe": self.recipe.resolved(self.config), "split": split, "where": where, **more}

    def folder(self, description: Mapping[str, Any]) -> Path:
        """Return the folder of the results, which can be written to."""
        resolved = description["recipe"] | {k: v for k, v in description.items() if k != "recipe"}
        stem = f"crossval-{self.request.model}-{Path(self.request.recipe).stem}"
        folder = Path("runs") / f"{stem}-{run_id(resolved, self.store.sha256)}"
        folder = Path(self.request.out) if self.request.out else folder
        check_writable(folder, folder=True)
        return folder

    def processes(self, folds: int) -> int:
        """Return the number of processes for so many folds: as requested, by default one per core, on a GPU one."""
        if self.request.processes is not None or self.request.on:
            return self.request.processes or 1
        device = make_fabric(self.recipe.training, accelerator=self.request.accelerator).device.type
        return min(cores(), folds) if device == "cpu" else 1

    def kept(
        self,
        function: Callable[[T], dict[str, Any]],
        tasks: Sequence[T],
        parts: Sequence[Any],
        folder: Path,
        **options: Any,
    ) -> list[dict[str, Any]]:
        """Return the value of each task, which stays in ``folder`` until all are done, for one that is started again.

        ``parts`` tell the tasks apart, as JSON; ``options`` are those of `kept_values`.
        """
        request, kept = self.request, folder / "folds"
        facts = {"model": request.model, "label": request.label, **self.recipe.resolved(self.config)}
        facts |= {"where": dict(request.where or {})}
        ids = [run_id(facts | {"parts": part}, self.store.sha256) for part in parts]
        files, processes = [kept / f"{id}.json" for id in ids], self.processes(len(tasks))
        values = kept_values(function, tasks, files, on=request.on, processes=processes, **options)
        shutil.rmtree(kept)
        return values

    def learner(self, kind: Kind, *, seed: int) -> Model:
        """Return an untrained model of a kind of examples on its device."""
        learner = self.facts.build(self.config, kind, seed=seed)
        learner.setup(make_fabric(self.recipe.training, accelerator=self.request.accelerator))
        return learner
