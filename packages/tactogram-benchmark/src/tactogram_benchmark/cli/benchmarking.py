"""Verbs of the benchmark, and of published tables and figures."""

from pathlib import Path
from typing import Any

from tactogram.cli.printing import Printer, columns, lines_of, terminal_width, text_of
from tactogram.cli.verbs import Verb


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


def _experiments(show: Printer) -> None:
    from tactogram_benchmark.experiments.catalogue import data_text, experiments, header_of, result_files

    listed: dict[str, Any] = {}
    rows = [("experiment", "finished", "recipe", "data", "result", "title")]
    for name, title in experiments().items():
        files = result_files(name)
        headers = {_short(file): header_of(file) for file in files}
        listed[name] = {"title": title, "results": headers}
        for file, header in headers.items() or [("not run", {})]:
            finished = str(header.get("finished", "-"))[:10]
            rows.append((name, finished, header.get("recipe", "-"), data_text(header) or "-", file, title))
    show(listed, columns(rows))


def _short(file: Path) -> str:
    """Return the path of a file, relative to the current folder if it is inside."""
    return str(file.relative_to(Path.cwd()) if file.is_relative_to(Path.cwd()) else file)


def _figures(result: dict[str, Any]) -> str:
    rows = result["rows"]
    cells = [(r["model"], r["what"], text_of(r["published"]), text_of(r["ours"]), r["data"]) for r in rows]
    head = [("model", "what", "published", "ours", "our data")]
    return columns(head + cells, width=terminal_width())


WORKFLOWS = "tactogram_benchmark.workflows"
CATALOGUE = "tactogram_benchmark.experiments.catalogue"
PLACES = ("tasks", "stores")

VERBS = {
    "benchmark list": Verb(f"{WORKFLOWS}:list_tasks", _tasks, folders=PLACES),
    "benchmark run": Verb(
        f"{WORKFLOWS}:run_benchmark",
        _run,
        folders=("models", *PLACES),
        status=lambda report: 0 if report["complete"] else 1,
    ),
    "benchmark table": Verb(f"{WORKFLOWS}:rank_results", lambda result: result["text"], folders=("tasks",)),
    "benchmark check": Verb(f"{WORKFLOWS}:check_file", lines_of, folders=("tasks",)),
    "benchmark questions": Verb(f"{WORKFLOWS}:ask_questions", lines_of, folders=PLACES),
    "benchmark score": Verb(f"{WORKFLOWS}:score_answers", _scores, folders=PLACES),
    "reproduce": Verb(
        f"{CATALOGUE}:reproduce",
        lambda result: result["text"],
        listing=("list the experiments", _experiments),
    ),
    "table": Verb(f"{CATALOGUE}:published_figures", _figures, folders=("models",)),
}
