"""Benchmark run: models on tasks, each with several seeds, on any number of workers."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram import models
from tactogram.errors import DataError, ParameterError, StoppedError, TactogramError, one_line
from tactogram.plugins import further_folders
from tactogram.signal.io import check_writable
from tactogram.workflows import LoadedRun, ProgressCallback, load_run, run_tasks, silent
from tactogram_benchmark.data import STORES_VARIABLE, OpenTask, open_task
from tactogram_benchmark.ignoring import IGNORING
from tactogram_benchmark.questions import check_answers
from tactogram_benchmark.result import BenchmarkResult, Entry, device, result_of
from tactogram_benchmark.shown import save_shown
from tactogram_benchmark.task import (
    FOLDERS_VARIABLE as TASKS_VARIABLE,
    BenchmarkTask,
    TaskRecipe,
    available_tasks,
)
from tactogram_benchmark.task_kind import TaskKind, kind_of
from tactogram_benchmark.training import trained_for, training_plan, training_seconds

SEEDS = 3
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


def run_benchmark(
    tasks: Sequence[str] = (),
    chosen: Sequence[str] = (),
    *,
    seeds: int = SEEDS,
    folder: Path | str = "runs/benchmark",
    out: Path | str | None = None,
    stores: Sequence[Path | str] = (),
    task_folders: Sequence[Path | str] = (),
    model_folders: Sequence[Path | str] = (),
    recipe: str = "",
    longest_min: float = math.inf,
    again: bool = False,
    on: str = "",
    processes: int = 1,
    progress: ProgressCallback = silent,
) -> dict[str, Any]:
    """Answer tasks with models, and write a result for each model, task and seed.

    Results that are there, of the same version of the task and the same recipe, are kept, unless they failed: an
    interrupted run goes on. So are trainings.

    Parameters
    ----------
    tasks, chosen : sequence of str
        Names of tasks, and of models or baselines; by default all, each on the tasks that it fits.
    seeds : int
        Number of seeds, from 0; baselines are not trained, and have one, except those that
        ignore what is given.
    folder : path
        Work folder: simulated stores, trainings and reference models.
    out : path, optional
        Folder of the results; default ``FOLDER/results``.
    stores : sequence of path
        Recorded stores, or folders of them; those in ``TACTOGRAM_STORES`` are added.
    task_folders, model_folders : sequence of path
        Further tasks and models.
    recipe : str
        Recipe of all models, in place of each task's.
    longest_min : float, minutes
        Longest training of one model, task and seed. A longer one is stopped, and its result says so; the next run
        continues it.
    again : bool
        Whether results that are there are measured again.
    on, processes
        As of `tactogram.workflows.workers.run_tasks`.

    Returns
    -------
    dict
        ``results`` (number of files written), ``kept``, ``failed`` and ``skipped``: a line each; ``out``.

    Raises
    ------
    ParameterError
        For an unknown task or model, more seeds than the tasks state, or a folder that cannot be written to.
    """
    known = available_tasks(task_folders)
    if unknown := [name for name in tasks if name not in known]:
        raise ParameterError(f"task must be one of {', '.join(known)}, got {unknown[0]!r}")
    models_known = {*models.available(model_folders)}.union(
        *(kind_of(t.kind).baselines for t in known.values())
    )
    if unknown := [name for name in chosen if name not in models_known]:
        raise ParameterError(
            f"no task or model is called {unknown[0]!r}: `tactogram benchmark list` and `tactogram models` list them"
        )
    if seeds > (most := max(len(known[name].seeds) for name in tasks or known)):
        raise ParameterError(f"seeds must be at most {most}, those that the tasks state, got {seeds}")
    work = Path(folder).resolve()
    place = Path(out).resolve() if out else work / "results"
    # A worker on another machine has not this environment.
    places = {
        "stores": _folders(STORES_VARIABLE, stores),
        "task_folders": _folders(TASKS_VARIABLE, task_folders),
        "model_folders": _folders(models.FOLDERS_VARIABLE, model_folders),
    }
    for each in (work, place):
        check_writable(each, folder=True)
    cells: list[BenchmarkCell] = []
    skipped: list[str] = []
    named: set[str] = set()
    for name in tasks or known:
        try:
            opened = open_task(known[name], work, stores, progress=progress)
            kind_of(opened.task.kind).check(opened)
        except DataError as error:
            skipped.append(str(error))
            continue
        entries = entries_of(opened, model_folders)
        named |= entries.keys()
        cells += [
            BenchmarkCell(name, model, entry, seed, str(work), str(place), recipe, longest_min, **places)
            for model, entry in entries.items()
            if not chosen or model in chosen
            for seed in opened.task.seeds[: seeds if entry == "model" or model in IGNORING else 1]
        ]
    if missing := [name for name in chosen if name not in named] if named else []:
        raise ParameterError(
            f"model must be one that fits these tasks ({', '.join(sorted(named))}), got {missing[0]!r}"
        )
    todo = [cell for cell in cells if again or not _is_done(cell, known[cell.task])]
    todo.sort(key=lambda cell: cell.seed)  # interrupted, it leaves every model with as many seeds
    failed, written = [], 0
    outcomes = run_tasks(
        answer_cell, todo, on=on, processes=processes, name=lambda cell: cell.name, progress=progress
    )
    for outcome in outcomes:
        problem = outcome.error or outcome.value
        written += not outcome.error
        if problem:
            failed.append(f"{outcome.task.name}: {problem}")
    return {
        "results": written,
        "kept": len(cells) - len(todo),
        "failed": failed,
        "skipped": skipped,
        "out": str(place),
    }


def _folders(variable: str, given: Sequence[Path | str]) -> tuple[str, ...]:
    return tuple(str(path.resolve()) for path in further_folders(variable, given))


def entries_of(opened: OpenTask, model_folders: Sequence[Path | str] = ()) -> dict[str, Entry]:
    """Return the models and baselines that can answer a task."""
    kind = kind_of(opened.task.kind)
    found: dict[str, Entry] = {
        name: "model" for name, facts in models.available(model_folders).items() if kind.fits(opened, facts)
    }
    return found | dict.fromkeys(kind.baselines, "baseline")


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
            f"not trained within {cell.longest_min:g} minutes on {device()}; run again with a larger `longest_min`"
        ) from error
    return loaded, {
        "recipe": _recipe_of(cell, opened.task),
        "settings": plan.recipe.resolved(plan.config),
        "training_s": training_seconds(loaded.run.folder),
    }


def _is_done(cell: BenchmarkCell, task: BenchmarkTask) -> bool:
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
