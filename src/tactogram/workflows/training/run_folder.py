"""Folder of a run before its first step: made, claimed or discarded."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tactogram.errors import RunError
from tactogram.signal.io.atomic import lock
from tactogram.training.run import Run
from tactogram.workflows.training.plan import TrainingPlan

BEGUN = ("recipe.toml", "data.json", "environment.json", "split.json")
"""Files of a run before its first step; the recipe, which makes it a run, first."""


def claim_run(run: Run, identity: str, resume: bool) -> None:
    """Refuse a folder that holds a run, or with ``resume`` one that holds none of the same identity."""
    if not resume:
        run.check_free()
        return
    if not (run.folder / "recipe.toml").exists():
        raise RunError(f"{run.folder}: nothing to resume here; omit `resume` to start a run")
    if run.data["run_id"] != identity:
        raise RunError(
            f"{run.folder}: was begun with another recipe, split or data; resume with the same ones, "
            "or choose another `out`"
        )
    check_idle(run.folder)


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


HELD = "recipe.toml"
"""Locked during training: this file is written once, never replaced, and lasts as long as the run."""

TRIES, BETWEEN_S = 10, 0.02
"""Retries while another process briefly holds the lock to look."""


@contextmanager
def run_lock(folder: Path) -> Iterator[None]:
    """Lock a run's folder for this process; the system unlocks it however the process ends.

    Raises
    ------
    RunError
        If another process trains there.
    """
    with (folder / HELD).open("rb") as file:
        for left in reversed(range(TRIES)):
            if _locked(file.fileno()):
                break
            if not left:
                raise _taken(folder)
            time.sleep(BETWEEN_S)
        yield


def check_idle(folder: Path) -> None:
    """Refuse a run's folder in which another process trains, as `run_lock` does, before anything is prepared.

    Raises
    ------
    RunError
        If another process trains there.
    """
    if is_training(folder):
        raise _taken(folder)


def is_training(folder: Path) -> bool:
    """Return whether a process trains in a run's folder."""
    try:
        with (folder / HELD).open("rb") as file:
            return not _locked(file.fileno(), shared=True)
    except OSError:
        return False


def _taken(folder: Path) -> RunError:
    return RunError(f"{folder}: another process trains here at present; wait for it, or stop it first")


def _locked(file: int, *, shared: bool = False) -> bool:
    """Lock a file until it is closed; return whether that succeeded. On Windows nothing is locked."""
    if sys.platform == "win32":
        return True
    return lock(file, shared=shared)
