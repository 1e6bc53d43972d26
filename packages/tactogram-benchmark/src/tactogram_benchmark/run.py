"""Benchmark run: models on tasks, each with several seeds, on any number of workers."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram import models
from tactogram.errors import ParameterError, Remedy, StoppedError, TactogramError, one_line
from tactogram.workflows import LoadedRun, load_run, silent
from tactogram_benchmark.data import OpenTask, open_task
from tactogram_benchmark.result import BenchmarkResult, Entry, device, result_of, save_shown
from tactogram_benchmark.task import (
    BenchmarkTask,
    TaskRecipe,
    available_tasks,
)
from tactogram_benchmark.task_kind import TaskKind, check_answers, kind_of
from tactogram_benchmark.training import trained_for, training_plan, training_seconds

SHIPPED = "as it comes, untrained for the task"
BASELINE = "baseline of the task"


@dataclass(frozen=True)
class BenchmarkCell:
    """One model on one task with one seed."""

    task: str
    model: str
    entry: Entry
    seed: int
    folder: str
    out: str
    recipe: str = ""
    longest_min: float = math.inf
    stores: tuple[str, ...] = ()
    task_folders: tuple[str, ...] = ()
    model_folders: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Task, model and seed, for progress."""
        return f"{self.task} {self.model} {self.seed}"

    @property
    def file(self) -> Path:
        """Where the result belongs."""
        return Path(self.out) / self.task / f"{self.model}-{self.seed}.json"


def entries_of(opened: OpenTask, model_folders: Sequence[Path | str] = ()) -> dict[str, Entry]:
    """Return the models and baselines that can answer a task."""
    kind = kind_of(opened.task.kind)
    entries: dict[str, Entry] = {
        name: "model" for name, facts in models.available(model_folders).items() if kind.fits(opened, facts)
    }
    return entries | dict.fromkeys(kind.baselines, "baseline")


def answer_cell(cell: BenchmarkCell) -> str:
    """Train, answer and judge one cell, write its result, and return why it failed; "" if it did not."""
    task = available_tasks(cell.task_folders)[cell.task]
    opened, kind = open_task(task, Path(cell.folder), cell.stores), kind_of(task.kind)
    try:
        judged = _judged(cell, opened, kind)
    except TactogramError as error:
        result_of(opened, cell.model, cell.entry, cell.seed, failed=one_line(error)).save(Path(cell.out))
        return one_line(error)
    judged.save(Path(cell.out))
    return ""


def _judged(cell: BenchmarkCell, opened: OpenTask, kind: TaskKind) -> BenchmarkResult:
    questions = kind.questions(opened)
    began = time.perf_counter()
    if cell.entry == "baseline":
        answers: Mapping[str, Any] = kind.baselines[cell.model](opened, questions, cell.seed)
        facts: dict[str, Any] = {"recipe": BASELINE}
        trained = 0.0
    else:
        loaded, facts = _loaded(cell, opened, kind)
        trained = time.perf_counter() - began
        answers = {question.id: kind.answer(opened, loaded, question, cell.seed) for question in questions}
    answered = time.perf_counter() - began - trained
    check_answers(kind.form(opened), questions, answers, where=cell.name)
    judgement = kind.judged(opened, answers, silent)
    if cell.seed == 0:
        save_shown(Path(cell.out), cell.task, cell.model, judgement.shown, simulated=opened.store.simulated)
    return result_of(
        opened, cell.model, cell.entry, cell.seed, judgement, answering_s=round(answered, 2), **facts
    )


def _loaded(cell: BenchmarkCell, opened: OpenTask, kind: TaskKind) -> tuple[LoadedRun, dict[str, Any]]:
    """Return the trained model of a cell, and the facts of its training for the result."""
    folders = tuple(map(Path, cell.model_folders))
    facts = models.find(cell.model, folders)
    if kind.uses_shipped(opened, facts):
        loaded = load_run(cell.model)
        return loaded, {
            "recipe": SHIPPED,
            "settings": loaded.recipe.model_dump(mode="json"),
        }
    plan = training_plan(opened, facts, seed=cell.seed, recipe=cell.recipe, model_folders=folders)
    ends = time.perf_counter() + 60 * cell.longest_min
    try:
        loaded = trained_for(
            opened,
            facts,
            seed=cell.seed,
            recipe=cell.recipe,
            model_folders=folders,
            stop=lambda: time.perf_counter() > ends,
        )
    except StoppedError as error:
        raise ParameterError(
            f"not trained within {cell.longest_min:g} minutes on {device()}",
            remedy=Remedy("run again with a larger", "longest_min"),
        ) from error
    return loaded, {
        "recipe": _recipe_of(cell, opened.task),
        "settings": plan.recipe.resolved(plan.config),
        "training_s": training_seconds(loaded.run.folder),
    }


def is_done(cell: BenchmarkCell, task: BenchmarkTask) -> bool:
    """Return whether there is a result of this version of the task and this recipe that did not fail."""
    if not cell.file.is_file():
        return False
    try:
        result = BenchmarkResult.load(cell.file)
    except TactogramError:
        return False
    current = result.task_sha256 == task.sha256 and result.judge == kind_of(task.kind).version
    asked = result.recipe in (_recipe_of(cell, task), SHIPPED, BASELINE)
    return current and asked and not result.failed


def _recipe_of(cell: BenchmarkCell, task: BenchmarkTask) -> str:
    return cell.recipe or task.recipes.get(cell.model, TaskRecipe()).recipe
