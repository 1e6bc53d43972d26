"""Folder of a run before its first step: made, claimed or discarded."""

from __future__ import annotations

import os
from typing import Any

from tactogram.errors import Remedy, RunError
from tactogram.training.run import Run
from tactogram.workflows.training.plan import TrainingPlan
from tactogram.workflows.training.run_lock import is_training, taken

BEGUN = ("recipe.toml", "data.json", "environment.json", "split.json")
"""Files of a run before its first step; the recipe, which makes it a run, first."""


def claim_run(run: Run, identity: str, resume: bool) -> None:
    """Refuse a folder that holds a run, or with ``resume`` one that holds none of the same identity."""
    if not resume:
        run.check_free()
        return
    if not (run.folder / "recipe.toml").exists():
        remedy = Remedy("to start a run, omit", "resume")
        raise RunError(run.folder, "nothing to resume here", remedy=remedy)
    if run.data["run_id"] != identity:
        raise RunError(
            run.folder,
            "was begun with another recipe, split or data",
            remedy=(Remedy("resume with the same ones"), Remedy("choose another", "out")),
        )
    if is_training(run.folder):  # before anything is prepared
        raise taken(run.folder)


def begin(run: Run, plan: TrainingPlan) -> None:
    """Make the folder of a new run, with all that `tactogram.workflows.training.execution.resume` needs.

    Raises
    ------
    RunError
        If another process made a run there meanwhile, which is left untouched.
    """
    run.check_free()
    store, split = plan.store, plan.parts
    data: dict[str, Any] = {
        "path": store.path if isinstance(store.path, str) else os.fspath(store.path.resolve()),
        "name": store.name,
        "licence": store.licence,
        "sha256": store.sha256,
        "simulated": store.simulated,
        "label": plan.label,
        "split": {"by": split.by, **{part: len(held) for part, held in split.parts.items()}},
    }
    if plan.model_folders:
        data["model_folders"] = [os.fspath(path.resolve()) for path in plan.model_folders]
    if split.photographs:
        data["photographs"] = {part: len(held) for part, held in split.photographs.items()} | {
            "note": split.photograph_note
        }
    run.folder.mkdir(parents=True, exist_ok=True)
    # Before the recipe, which makes it a run: a kill leaves a run with its split, or none.
    split.save(run.folder / "split.json")
    # Defaults included, so that the run stays what it is when they change. TOML has no null.
    config = plan.config.model_dump(mode="json", exclude_none=True)
    recipe = plan.recipe.model_copy(update={"config": config})
    Run.create(run.folder, recipe=recipe, data=data, identity=plan.identity)


def discard_run(run: Run) -> None:
    """Remove the files of `begin` for a run that was refused in its first step: there is nothing to resume."""
    if (run.folder / "checkpoint.safetensors").exists() or run.metrics():
        return
    for name in BEGUN:
        (run.folder / name).unlink(missing_ok=True)
    if not any(run.folder.iterdir()):
        run.folder.rmdir()
