"""Steps that every cross-validation shares: its model, recipe and recordings, and the folder of its results."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram import models
from tactogram.datasets import RecordingInfo, Store, open_store
from tactogram.datasets.examples import cores
from tactogram.errors import ParameterError
from tactogram.evaluation.report import save_figure
from tactogram.model import Kind, Model, ModelConfig
from tactogram.recipe import Recipe, run_id
from tactogram.signal.io.atomic import write_text
from tactogram.signal.io.writable import check_writable
from tactogram.training.device import make_fabric
from tactogram.workflows.progress import silent
from tactogram.workflows.training.plan import select
from tactogram.workflows.training.requests import CrossvalRequest
from tactogram.workflows.workers import absolute

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    def of(cls, request: CrossvalRequest, *, task: str) -> CrossvalSetup:
        """Open the data and the model; refuse a model of another task."""
        facts = models.find(request.model, [Path(folder) for folder in request.model_folders])
        if facts.task != task == "prediction":
            raise ParameterError(f"{request.model} is no predictor of ratings")
        if facts.task != task:
            raise ParameterError(
                f"crossval is for classifiers and predictors of ratings; {request.model} is for {facts.task}: "
                "train and evaluate it"
            )
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

    def request_for_workers(self) -> CrossvalRequest:
        """Return the request as a worker in another folder can carry it out."""
        request = self.request
        return replace(
            request,
            data=absolute(request.data),
            recipe=absolute(request.recipe) if request.recipe.endswith(".toml") else request.recipe,
            model_folders=[absolute(folder) for folder in request.model_folders],
            progress=silent,
        )

    def learner(self, kind: Kind, *, seed: int) -> Model:
        """Return an untrained model of a kind of examples on its device."""
        learner = self.facts.build(self.config, kind, seed=seed)
        learner.setup(make_fabric(self.recipe.training, accelerator=self.request.accelerator))
        return learner


def write_results(folder: Path, figures: Mapping[str, Any], image: str, figure: Figure) -> None:
    """Write ``crossval.json`` and an image of the results."""
    save_figure(folder / image, figure)
    write_text(folder / "crossval.json", json.dumps(figures, indent=1) + "\n")
