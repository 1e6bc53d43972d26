"""Training of a model for a task, on its training part alone; kept, and shared by tasks of the same data and split."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from tactogram.models import ModelInfo
from tactogram.recipe import Recipe
from tactogram.signal.io import lock, write_text
from tactogram.training import Run
from tactogram.validation import with_changes
from tactogram.workflows import (
    LoadedRun,
    ProgressCallback,
    RatingData,
    TrainingPlan,
    load_run,
    never,
    silent,
    train_plan,
)
from tactogram_benchmark.data import OpenTask, rated_surfaces
from tactogram_benchmark.task import TaskRecipe
from tactogram_benchmark.task_kind import kind_of

SECONDS = "training_s.txt"
BETWEEN_S = 0.5
"""Between looks whether another worker has finished a shared training."""


def trained_for(
    opened: OpenTask,
    model: ModelInfo,
    *,
    seed: int,
    recipe: str = "",
    folder: str = "trainings",
    model_folders: tuple[Path, ...] = (),
    progress: ProgressCallback = silent,
    stop: Callable[[], bool] = never,
) -> LoadedRun:
    """Return the run of a model trained for a task.

    Parameters
    ----------
    opened : OpenTask
    model : ModelInfo
    seed : int
        Of the training.
    recipe : str
        Name or file; default: the one that the task names for the model, else ``quick``.
    folder : str
        Part of the work folder.
    model_folders : tuple of Path
        Where models from outside are.
    stop : callable
        Asked after each step: True ends the training, which is continued the next time.

    Raises
    ------
    ParameterError
        If the model cannot learn from the data.
    StoppedError
        If ``stop`` ended it.
    """
    plan = training_plan(opened, model, seed=seed, recipe=recipe, model_folders=model_folders)
    run_folder = opened.folder / folder / f"{model.name}-{plan.identity}"
    with _alone(run_folder):
        run = Run(run_folder)
        if run.finished:
            run.forget_checkpoint()
        else:
            begun, before = (run_folder / "recipe.toml").is_file(), training_seconds(run_folder) or 0.0
            started = time.perf_counter()
            try:
                train_plan(
                    plan,
                    run,
                    resume=begun,
                    accelerator="auto",
                    prepared=opened.prepared,
                    progress=progress,
                    stop=stop,
                )
            finally:
                if run_folder.is_dir():  # unless it was refused
                    write_text(run_folder / SECONDS, f"{before + time.perf_counter() - started:.1f}\n")
    return load_run(run_folder, model_folders=model_folders)


def training_seconds(place: Path) -> float | None:
    """Return the time that the training in a run's folder took, over all interruptions; None if that is not known."""
    file = place / SECONDS
    return float(file.read_text(encoding="utf-8")) if file.is_file() else None


@contextmanager
def _alone(run_folder: Path) -> Iterator[None]:
    """Wait while another worker trains the same run: tasks of one data set and split share it."""
    run_folder.parent.mkdir(parents=True, exist_ok=True)
    with run_folder.with_name(f"{run_folder.name}.lock").open("ab") as file:
        while not lock(file.fileno()):
            time.sleep(BETWEEN_S)
        yield


def training_plan(
    opened: OpenTask, model: ModelInfo, *, seed: int, recipe: str = "", model_folders: tuple[Path, ...] = ()
) -> TrainingPlan:
    """Return the plan of `trained_for`; arguments and errors as there."""
    facts = model.of(images=not len(opened.store))
    chosen = opened.task.recipes.get(model.name, TaskRecipe())
    file = facts.recipe(recipe or chosen.recipe)
    read = Recipe.load(file, changes=chosen.changes if not recipe else None)
    values = with_changes(read.model_dump(), {"seed": seed, "prepare": opened.task.prepare.model_dump()})
    full_recipe = Recipe.of(values, where=str(file))
    rated = None if facts.learns_from == "recordings" else RatingData(opened.store, facts.learns_from)
    split, label = opened.split, opened.task.label
    if kind_of(opened.task.kind).validation_judges:
        photographs = {part: held for part, held in split.photographs.items() if part != "validation"}
        split = replace(split, validation=(), photographs=photographs)
    if facts.learns_from == "both":
        split = replace(split, train=split.train + rated_surfaces(opened))
    return TrainingPlan(
        opened.store,
        facts,
        full_recipe,
        facts.config(full_recipe.config),
        split,
        rated,
        label,
        model_folders,
    )
