"""Verbs of the benchmark: list, run, table, check, questions, score."""

from typing import Any

from tactogram.cli.functions import FunctionVerb
from tactogram.cli.printing import columns, lines_of, text_of


def _tasks(tasks: dict[str, Any]) -> str:
    rows = [(name, task["data"], task["state"], task["title"]) for name, task in tasks.items()]
    return columns([("task", "data", "", "title"), *rows])


def _run(report: dict[str, Any]) -> str:
    lines = [f"{report['results']} results written, {report['kept']} kept: {report['out']}"]
    return "\n".join(lines + [f"{why}: {line}" for why in ("failed", "skipped") for line in report[why]])


def _scores(facts: dict[str, Any]) -> str:
    rows = [("seed", next(iter(facts["results"][0]["figures"])), "interval", "at best", "by chance")]
    for result in facts["results"]:
        main = next(iter(result["figures"].values()))
        known = main["low"] is not None and main["high"] is not None
        interval = f"{main['low']:.4g} to {main['high']:.4g}" if known else "-"
        rows.append(
            (
                str(result["seed"]),
                text_of(main["value"]),
                interval,
                text_of(main["floor"]),
                text_of(main["ceiling"]),
            )
        )
    return "\n".join([columns(rows), facts["sentence"], *(f"result: {file}" for file in facts["files"])])


WORKFLOWS = "tactogram_benchmark.workflows"
PLACES = ("tasks", "stores")

VERBS = {
    "benchmark list": FunctionVerb(f"{WORKFLOWS}:list_tasks", _tasks, folders=PLACES),
    "benchmark run": FunctionVerb(
        f"{WORKFLOWS}:run_benchmark",
        _run,
        folders=("models", *PLACES),
        status=lambda report: 0 if report["complete"] else 1,
    ),
    "benchmark table": FunctionVerb(
        f"{WORKFLOWS}:rank_results", lambda result: result["text"], folders=("tasks",)
    ),
    "benchmark check": FunctionVerb(f"{WORKFLOWS}:check_file", lines_of, folders=("tasks",)),
    "benchmark questions": FunctionVerb(f"{WORKFLOWS}:ask_questions", lines_of, folders=PLACES),
    "benchmark score": FunctionVerb(f"{WORKFLOWS}:score_answers", _scores, folders=PLACES),
}
