"""Resumption of an unfinished run from its folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tactogram import models
from tactogram.datasets import Split, open_store
from tactogram.errors import DataError, RunError
from tactogram.training.run import Run
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.training.plan import TrainingPlan
from tactogram.workflows.training.rated_examples import RatingData
from tactogram.workflows.training.train import Stop, never, train_plan


def resume(
    folder: Path | str,
    *,
    data: Path | str | None = None,
    accelerator: str = "auto",
    devices: int = 1,
    model_folders: Sequence[Path] = (),
    progress: ProgressCallback = silent,
    stop: Stop = never,
) -> Run:
    """Go on with the run in ``folder`` from its last checkpoint, and return it finished.

    Parameters
    ----------
    folder : path
    data : path, optional
        Where its data set lies now; by default where it lay when the run began.
    accelerator, devices, progress, stop
        As of `tactogram.workflows.training.train.train`.
    model_folders : sequence of Path
        Folders with further models, besides those that it was begun with.

    Raises
    ------
    RunError
        If there is no run, its data is gone or has changed, it does not say its split, or another process is at it.
    StoppedError
        If ``stop`` said so; the message says how much is kept.
    """
    run = Run.open(Path(folder))
    if run.finished:
        return run
    plan = plan_of(run, data=data, model_folders=model_folders)
    return train_plan(
        plan,
        run.folder,
        resume=True,
        accelerator=accelerator,
        devices=devices,
        progress=progress,
        stop=stop,
    )


def plan_of(run: Run, *, data: Path | str | None = None, model_folders: Sequence[Path] = ()) -> TrainingPlan:
    """Return what the training of ``run`` is of, as its folder says.

    Parameters and errors as of `resume`.
    """
    (begun, parts), recipe = _asked(run), run.recipe
    path = data or begun["path"]
    try:
        store = open_store(path)
    except DataError as error:
        raise RunError(f"{run.folder}: its data is not at {path}; give --data: {error}") from error
    if store.sha256 != begun["sha256"]:
        raise RunError(
            f"{run.folder}: {path} is not the data set as it was when the run began; give it with --data as it "
            "was then, or begin another run"
        )
    folders = (*model_folders, *(Path(kept) for kept in begun.get("model_folders", ())))
    facts = models.find(recipe.model, folders)
    rated = None if facts.learns_from == "recordings" else RatingData(store, facts.learns_from)
    return TrainingPlan(
        store, facts, recipe, facts.config(recipe.config), parts, rated, begun["label"], folders
    )


def _asked(run: Run) -> tuple[dict[str, Any], Split]:
    """Return what a run says of its data and of its split, or say how to go on without."""
    begun, split = run.data, run.folder / "split.json"
    missing = [f"data.json: {name}" for name in ("path", "sha256", "label") if name not in begun]
    missing += [] if split.is_file() else [split.name]
    if missing:
        raise RunError(
            f"{run.folder}: does not hold what it was asked for (no {', '.join(missing)}); go on with `tactogram train "
            f"{run.recipe.model} --data DIR … --out {run.folder} --resume` and the same arguments as then"
        )
    return begun, Split.load(split)
