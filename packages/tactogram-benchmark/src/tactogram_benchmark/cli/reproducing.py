"""Verbs on published tables and figures."""

from pathlib import Path
from typing import Any

from tactogram.cli.functions import FunctionVerb
from tactogram.cli.printing import Printer, columns, terminal_width, text_of

REPRODUCE = "tactogram_benchmark.experiments.reproduce"


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


VERBS = {
    "reproduce": FunctionVerb(
        f"{REPRODUCE}:reproduce",
        lambda result: result["text"],
        listing=("list the experiments", _experiments),
    ),
    "table": FunctionVerb(f"{REPRODUCE}:published_figures", _figures, folders=("models",)),
}
