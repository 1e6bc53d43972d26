"""Resumption of an unfinished run from its folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from tactogram import models
from tactogram.datasets import Split, open_store
from tactogram.errors import DataError, RunError
from tactogram.training.run import Run, open_run
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.plan import TrainingPlan
from tactogram.workflows.training.rated_examples import RatingData
from tactogram.workflows.training.requests import LoggerName, never
from tactogram.workflows.training.train import train_plan


def resume(
    folder: Path | str,
    *,
    data: Path | str | None = None,
    accelerator: str = "auto",
    devices: int = 1,
    logger: LoggerName | None = None,
    model_folders: Sequence[Path] = (),
    progress: ProgressCallback = silent,
    stop: Callable[[], bool] = never,
) -> Run:
    """Continue the run in ``folder`` from its last checkpoint, and return it finished.

    ``data`` is where its data set is now; by default where it was when the run began. ``model_folders`` are further to
    those recorded in the run. The others are as of `tactogram.workflows.training.train.train`.

    Raises
    ------
    RunError
        If there is no run, its data is gone or has changed, or another process trains it.
    DataError
        If its split is missing.
    StoppedError
        If ``stop`` ended it; the message names the last step.
    """
    run = open_run(folder)
    if run.finished:
        return run
    return train_plan(
        plan_of(run, data=data, model_folders=model_folders),
        run,
        resume=True,
        accelerator=accelerator,
        devices=devices,
        logger=logger,
        progress=progress,
        stop=stop,
    )


def plan_of(run: Run, *, data: Path | str | None = None, model_folders: Sequence[Path] = ()) -> TrainingPlan:
    """Return the plan that the folder of ``run`` records; errors as of `resume`."""
    begun, recipe, parts = run.data, run.recipe, Split.load(run.folder / "split.json")
    if missing := {"path", "sha256", "label"} - begun.keys():
        raise RunError(
            f"{run.folder / 'data.json'}: damaged: lacks {', '.join(sorted(missing))}; train again"
        )
    path = data or begun["path"]
    try:
        store = open_store(path)
    except DataError as error:
        raise RunError(f"{run.folder}: its data is not at {path}; give `data`: {error}") from error
    if store.sha256 != begun["sha256"]:
        raise RunError(
            f"{run.folder}: {path} has changed since the run began; give the unchanged data set as `data`, "
            "or start another run"
        )
    folders = (*model_folders, *(Path(kept) for kept in begun.get("model_folders", ())))
    facts = models.find(recipe.model, folders).of(images=not len(store))
    rated = None if facts.learns_from == "recordings" else RatingData(store, facts.learns_from)
    return TrainingPlan(
        store, facts, recipe, facts.config(recipe.config), parts, rated, begun["label"], folders
    )
