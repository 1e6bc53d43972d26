"""Resumption of an unfinished run from its folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

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
        If there is no run, its data is gone or has changed, its split is missing, or another process trains it.
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
    (begun, parts), recipe = _recorded(run), run.recipe
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


def _recorded(run: Run) -> tuple[dict[str, Any], Split]:
    """Return the data facts and split of a run, or refuse with the way to continue without them."""
    begun, split = run.data, run.folder / "split.json"
    missing = [f"data.json: {name}" for name in ("path", "sha256", "label") if name not in begun]
    missing += [] if split.is_file() else [split.name]
    if missing:
        raise RunError(
            f"{run.folder}: does not record its request (no {', '.join(missing)}); continue it with `tactogram train "
            f"{run.recipe.model} --data DIR … --out {run.folder} --resume` and the original arguments"
        )
    return begun, Split.load(split)
