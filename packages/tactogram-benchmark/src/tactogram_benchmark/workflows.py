"""Verbs of the benchmark as functions: list, run, table, check, questions, score."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import DataError, ParameterError
from tactogram.parameters import Count, Positive, checked, shares_out

if TYPE_CHECKING:
    from tactogram.workflows import ProgressCallback

WORK = "runs/benchmark"


@checked
def list_tasks(
    *,
    folder: Path | str = WORK,
    stores: Sequence[Path | str] = (),
    task_folders: Sequence[Path | str] = (),
) -> dict[str, dict[str, Any]]:
    """List the tasks, and whether their data is at hand.

    ``stores`` are recorded stores, or folders of them, and ``task_folders`` folders of further tasks, beside those in
    the environment.

    Parameters
    ----------
    folder : Path or str
        Work folder: simulated stores, trainings, reference models.

    Returns
    -------
    dict
        ``title``, ``kind``, ``data``, ``simulated`` and ``state`` of each task by name. The state is ``available``,
        ``simulated on demand``, or ``missing``, with the name of its importer.
    """
    from tactogram.plugins import further_folders
    from tactogram_benchmark.data import STORES_VARIABLE, find_store
    from tactogram_benchmark.task import available_tasks

    places = (Path(folder) / "stores", *further_folders(STORES_VARIABLE, stores))
    rows = {}
    for name, task in available_tasks(task_folders).items():
        there = find_store(task, places) is not None
        source = f"import {task.data.importer}" if task.data.importer else "name its folder by --stores"
        missing = "simulated on demand" if task.data.simulated else f"missing: {source}"
        rows[name] = {
            "title": task.title,
            "kind": task.kind,
            "data": task.data.what,
            "simulated": task.data.simulated,
            "state": "available" if there else missing,
        }
    return rows


@checked
@shares_out
def run_benchmark(
    names: Sequence[str] = (),
    *,
    folder: Path | str = WORK,
    seeds: Count = 3,
    recipe: str = "",
    out: Path | str | None = None,
    longest_min: Positive | None = None,
    again: bool = False,
    on: str = "",
    processes: Count = 1,
    stores: Sequence[Path | str] = (),
    task_folders: Sequence[Path | str] = (),
    model_folders: Sequence[Path | str] = (),
    progress: ProgressCallback | None = None,
) -> dict[str, Any]:
    """Train models for tasks, answer them, and write a result per model, task and seed.

    Results that are there, of the same version of the task and the same recipe, are kept, unless they failed: an
    interrupted run goes on. So are trainings. ``stores`` are recorded stores, or folders of them, ``task_folders`` and
    ``model_folders`` folders of further tasks and models, beside those in the environment.

    Parameters
    ----------
    names : sequence of str
        Tasks and models or baselines, by default all, each on the tasks that it fits.
    folder : Path or str
        Work folder: simulated stores, trainings, reference models.
    seeds : int
        Number of seeds, from 0; baselines are not trained, and have one, except those that ignore what is given.
    recipe : str
        Recipe of every model (default: the task's).
    out : Path or str, optional
        Folder of the results (default FOLDER/results).
    longest_min : float, optional
        Longest training of one model, task and seed, minutes; a longer one is stopped, and continued the next time.
    again : bool
        Measure again what has a result.
    on : str
        Engine: ray starts Ray on this machine, ray:ADDRESS takes a cluster.
    processes : int
        Processes on this machine.

    Returns
    -------
    dict
        ``results`` (number of files written), ``kept``, ``failed`` and ``skipped``: a line each; ``out``; ``complete``:
        nothing failed, and no task that was named was skipped.

    Raises
    ------
    ParameterError
        For an unknown task or model, more seeds than the tasks state, or a folder that cannot be written to.
    """
    from tactogram import models
    from tactogram.signal.io import check_writable, clear_parts
    from tactogram.workflows import run_tasks, silent
    from tactogram_benchmark.data import STORES_VARIABLE, open_task
    from tactogram_benchmark.ignoring import IGNORING
    from tactogram_benchmark.run import BenchmarkCell, answer_cell, entries_of, is_done
    from tactogram_benchmark.task import FOLDERS_VARIABLE, available_tasks
    from tactogram_benchmark.task_kind import kind_of

    progress = progress or silent
    known = available_tasks(task_folders)
    tasks = [name for name in names if name in known]
    chosen = [name for name in names if name not in known]
    models_known = {*models.available(model_folders)}.union(
        *(kind_of(t.kind).baselines for t in known.values())
    )
    if unknown := [name for name in chosen if name not in models_known]:
        raise ParameterError(
            f"no task or model is called {unknown[0]!r}: `tactogram benchmark list` and `tactogram models` list them"
        )
    if seeds > (most := max(len(known[name].seeds) for name in tasks or known)):
        raise ParameterError.must("seeds", f"be at most {most}, those that the tasks state", seeds)
    work = Path(folder).resolve()
    results = Path(out).resolve() if out else work / "results"
    # A worker on another machine has not this environment.
    places = {
        "stores": _folders(STORES_VARIABLE, stores),
        "task_folders": _folders(FOLDERS_VARIABLE, task_folders),
        "model_folders": _folders(models.FOLDERS_VARIABLE, model_folders),
    }
    for each in (work, results):
        check_writable(each, folder=True)
        clear_parts(each)
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
            BenchmarkCell(
                name, model, entry, seed, str(work), str(results), recipe, longest_min or math.inf, **places
            )
            for model, entry in entries.items()
            if not chosen or model in chosen
            for seed in opened.task.seeds[: seeds if entry == "model" or model in IGNORING else 1]
        ]
    if missing := [name for name in chosen if name not in named] if named else []:
        raise ParameterError.must(
            "model", f"be one that fits these tasks ({', '.join(sorted(named))})", missing[0]
        )
    todo = [cell for cell in cells if again or not is_done(cell, known[cell.task])]
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
        "out": str(results),
        "complete": not failed and not (skipped and tasks),
    }


def _folders(variable: str, folders: Sequence[Path | str]) -> tuple[str, ...]:
    from tactogram.plugins import further_folders

    return tuple(str(path.resolve()) for path in further_folders(variable, folders))


@checked
def rank_results(
    results: Sequence[Path | str],
    *,
    out: Path | str | None = None,
    task_folders: Sequence[Path | str] = (),
) -> dict[str, Any]:
    """Rank the models of every task from results.

    ``task_folders`` are folders of further tasks, beside those in the environment.

    Parameters
    ----------
    results : sequence of Path or str
        Folders of results.
    out : Path or str, optional
        A file: .md, .html for the page that sorts and plays, or .json for what `score` ranks among (default: print).

    Returns
    -------
    dict
        ``tasks``: by task the ranked models, ``rank``, ``value``, ``sd``, ``low``, ``high``, ``seeds``,
        ``not_told_apart`` and ``informed`` (better than what ignores the input). ``text``: the Markdown tables, or
        where the file was written.

    Raises
    ------
    ParameterError
        If ``out`` is of another format, there are no results, or one is of another version of its task.
    """
    from tactogram.signal.io import write_text
    from tactogram_benchmark.page import html
    from tactogram_benchmark.result import brief, check_result, read_results
    from tactogram_benchmark.table import markdown, tables_of
    from tactogram_benchmark.task import available_tasks

    suffix = Path(out).suffix if out else ".md"
    if suffix not in (".md", ".html", ".json"):
        raise ParameterError.must("out", "end with .md, .html or .json", out)
    folders = [Path(folder) for folder in results]
    tasks = available_tasks(task_folders)
    measured = read_results(folders)
    for result in measured:
        check_result(result, tasks, where=f"{result.task}/{result.model}-{result.seed}.json")
    tables = tables_of(measured, tasks)
    if not tables:
        raise ParameterError(
            f"{', '.join(map(str, folders))}: no results; `tactogram benchmark run` writes some"
        )
    text = markdown(tables)
    if out is not None:
        if suffix == ".json":
            text = brief(measured)
        write_text(Path(out), html(tables, folders) if suffix == ".html" else text)
        text = f"{len(tables)} tasks: {out}"
    kept = ("model", "entry", "value", "sd", "low", "high", "not_told_apart", "informed")
    ranked = {
        table.task.name: [
            {"rank": [entry.best_rank, entry.worst_rank], "seeds": len(entry.results)}
            | {name: getattr(entry, name) for name in kept}
            for entry in table.ranked
        ]
        for table in tables
    }
    return {"tasks": ranked, "text": text}


@checked
def check_file(file: Path | str) -> dict[str, Any]:
    """Check the file of a result.

    Parameters
    ----------
    file : Path or str
        A result, named and placed as `benchmark run` does.

    Returns
    -------
    dict
        ``task``, ``model``, ``seed``, ``main``, ``code`` and ``ok``.

    Raises
    ------
    DataError, ParameterError
        If it is no result, or of another version of its task.
    """
    from tactogram_benchmark.result import BenchmarkResult, check_result
    from tactogram_benchmark.task import available_tasks

    result = BenchmarkResult.load(Path(file))
    check_result(result, available_tasks(), where=str(file))
    if Path(file).name != result.file(Path()).name:
        raise ParameterError(f"{file}: must be called {result.file(Path()).name}; rename it")
    return {
        "task": result.task,
        "model": result.model,
        "seed": result.seed,
        "main": result.failed or f"{result.main_name} {result.main.value:.4g}",
        "code": result.code,
        "ok": True,
    }


@checked
def ask_questions(
    task: str,
    *,
    folder: Path | str = WORK,
    out: Path | str = "questions",
    progress: ProgressCallback | None = None,
) -> dict[str, Any]:
    """Write the training data and questions of a task as files for any framework.

    Parameters
    ----------
    task : str
        Name of a task.
    folder : Path or str
        Work folder: simulated stores, trainings, reference models.
    out : Path or str
        Folder for training data and questions.

    Returns
    -------
    dict
        As of `tactogram_benchmark.outside.write_questions`.
    """
    from tactogram_benchmark.data import open_named
    from tactogram_benchmark.outside import write_questions

    return write_questions(open_named(task, folder, progress), Path(out))


@checked
def score_answers(
    task: str,
    answers: Path | str,
    *,
    folder: Path | str = WORK,
    out: Path | str | None = None,
    progress: ProgressCallback | None = None,
) -> dict[str, Any]:
    """Score answers from files, and rank them among the results that come with the package.

    Parameters
    ----------
    task : str
        Name of a task.
    answers : Path or str
        Folder with about.json and 0.npz, 1.npz, … by seed.
    folder : Path or str
        Work folder: simulated stores, trainings, reference models.
    out : Path or str, optional
        Folder of the results (default FOLDER/results).

    Returns
    -------
    dict
        ``results`` and their ``files``; ``mean``, ``rank`` (best, worst), ``informed``, ``models`` (their number) and
        ``sentence``.

    Raises
    ------
    DataError
        If there are no answers, or a file is damaged.
    ParameterError
        If answers are incomplete or of another shape, or ``about.json`` is invalid.
    """
    from tactogram.workflows import silent
    from tactogram_benchmark import outside
    from tactogram_benchmark.data import open_named
    from tactogram_benchmark.result import committed_results
    from tactogram_benchmark.table import standing_of

    results_folder = Path(out or Path(folder) / "results")
    opened = open_named(task, folder, progress)
    results = outside.score_answers(opened, Path(answers), results_folder, progress=progress or silent)
    standing, sentence = standing_of(opened.task, results, committed_results())
    return {
        "results": [result.model_dump(mode="json") for result in results],
        "files": [str(result.file(results_folder)) for result in results],
        **standing,
        "sentence": sentence,
    }
