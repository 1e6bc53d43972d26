"""Verbs of the benchmark: list, run, table, check, questions, score."""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Annotated

from tactogram.cli.printing import Printer, columns, lines_of, text_of
from tactogram.cli.verbs import Verb
from tactogram.errors import ParameterError
from tactogram.workflows.request import ON, Argument, Option, Request

WORK = "runs/benchmark"


@dataclass(frozen=True)
class _Places(Request):
    _: KW_ONLY
    folder: Annotated[str, Option("work folder: simulated stores, trainings, reference models", "DIR")] = WORK


@dataclass(frozen=True)
class _RunRequest(_Places):
    names: Annotated[Sequence[str], Argument("tasks and models, by default all", metavar="TASK|MODEL")] = ()
    _: KW_ONLY
    seeds: Annotated[int, Option("number of seeds", least=1)] = 3
    recipe: Annotated[str, Option("recipe of every model (default: the task's)", "NAME|FILE")] = ""
    out: Annotated[str | None, Option("folder of the results (default FOLDER/results)", "DIR")] = None
    longest: Annotated[
        float | None,
        Option(
            "longest training in minutes; a longer one is stopped, and continued the next time",
            "MIN",
            above=0,
        ),
    ] = None
    again: Annotated[bool, Option("measure again what has a result")] = False
    on: Annotated[str, ON] = ""
    processes: Annotated[int, Option("processes on this machine", least=1)] = 1


@dataclass(frozen=True)
class _TableRequest(Request):
    results: Annotated[Sequence[str], Argument("folders of results", metavar="RESULTS")]
    _: KW_ONLY
    out: Annotated[
        str | None,
        Option(
            ".md, .html for the page that sorts and plays, or .json for what `score` ranks among (default: print)",
            "FILE",
        ),
    ] = None


@dataclass(frozen=True)
class _CheckRequest(Request):
    file: Annotated[str, Argument(metavar="FILE")]


@dataclass(frozen=True)
class _QuestionsRequest(_Places):
    task: Annotated[str, Argument(metavar="TASK")]
    _: KW_ONLY
    out: Annotated[str, Option("folder for training data and questions", "DIR")] = "questions"


@dataclass(frozen=True)
class _ScoreRequest(_Places):
    task: Annotated[str, Argument(metavar="TASK")]
    answers: Annotated[str, Argument("folder with about.json and 0.npz, 1.npz, … by seed", metavar="DIR")]
    _: KW_ONLY
    out: Annotated[str | None, Option("folder of the results (default FOLDER/results)", "DIR")] = None


def _list(request: _Places, show: Printer) -> None:
    from tactogram.benchmark.data import list_tasks

    found = list_tasks(request.folder)
    rows = [(name, task["data"], task["state"], task["title"]) for name, task in found.items()]
    show(found, columns([("task", "data", "", "title"), *rows]))


def _run(request: _RunRequest, show: Printer) -> int:
    from tactogram.benchmark.run import run_benchmark
    from tactogram.benchmark.task import available_tasks

    known = available_tasks()
    with show.progress() as progress:
        report = run_benchmark(
            [name for name in request.names if name in known],
            [name for name in request.names if name not in known],
            seeds=request.seeds,
            folder=request.folder,
            out=request.out,
            recipe=request.recipe,
            longest_min=request.longest or math.inf,
            again=request.again,
            on=request.on,
            processes=request.processes,
            progress=progress,
        )
    lines = [f"{report['results']} results written, {report['kept']} kept: {report['out']}"]
    lines += [f"failed: {line}" for line in report["failed"]] + [
        f"skipped: {line}" for line in report["skipped"]
    ]
    show(report, "\n".join(lines))
    asked_in_vain = report["skipped"] and any(name in known for name in request.names)
    return 1 if report["failed"] or asked_in_vain else 0


def _table(request: _TableRequest, show: Printer) -> None:
    from tactogram.benchmark.page import write_table

    report, text = write_table([Path(folder) for folder in request.results], request.out)
    show(report, text)


def _check(request: _CheckRequest, show: Printer) -> None:
    from tactogram.benchmark.result import BenchmarkResult, check_result
    from tactogram.benchmark.task import available_tasks

    result = BenchmarkResult.load(Path(request.file))
    check_result(result, available_tasks(), where=request.file)
    if Path(request.file).name != result.file(Path()).name:
        raise ParameterError(f"{request.file}: must be called {result.file(Path()).name}; rename it")
    facts = {
        "task": result.task,
        "model": result.model,
        "seed": result.seed,
        "main": result.failed or f"{result.main_name} {result.main.value:.4g}",
        "code": result.code,
        "ok": True,
    }
    show(facts, lines_of(facts))


def _questions(request: _QuestionsRequest, show: Printer) -> None:
    from tactogram.benchmark.data import open_task
    from tactogram.benchmark.outside import write_questions
    from tactogram.benchmark.task import find_task

    with show.progress() as progress:
        opened = open_task(find_task(request.task), Path(request.folder), progress=progress)
        report = write_questions(opened, Path(request.out))
    show(report, lines_of(report))


def _score(request: _ScoreRequest, show: Printer) -> None:
    from tactogram.benchmark.data import open_task
    from tactogram.benchmark.outside import score_answers
    from tactogram.benchmark.result import committed_results
    from tactogram.benchmark.table import standing_of
    from tactogram.benchmark.task import find_task

    work = Path(request.folder)
    out = Path(request.out or work / "results")
    with show.progress() as progress:
        opened = open_task(find_task(request.task), work, progress=progress)
        results = score_answers(opened, Path(request.answers), out, progress=progress)
    rows = [("seed", results[0].main_name, "interval", "at best", "by chance")]
    for result in results:
        main = result.main
        interval = "-" if main.low is None or main.high is None else f"{main.low:.4g} to {main.high:.4g}"
        ends = text_of(main.floor), text_of(main.ceiling)
        rows.append((str(result.seed), text_of(main.value), interval, *ends))
    files = [str(result.file(out)) for result in results]
    standing, sentence = standing_of(opened.task, results, committed_results())
    facts = {"results": [result.model_dump(mode="json") for result in results], "files": files, **standing}
    show(facts, "\n".join([columns(rows), sentence, *(f"result: {file}" for file in files)]))


PLACES = ("tasks", "stores")

VERBS = {
    "benchmark list": Verb(_Places, _list, folders=PLACES),
    "benchmark run": Verb(_RunRequest, _run, folders=("models", *PLACES)),
    "benchmark table": Verb(_TableRequest, _table, folders=("tasks",)),
    "benchmark check": Verb(_CheckRequest, _check, folders=("tasks",)),
    "benchmark questions": Verb(_QuestionsRequest, _questions, folders=PLACES),
    "benchmark score": Verb(_ScoreRequest, _score, folders=PLACES),
}
