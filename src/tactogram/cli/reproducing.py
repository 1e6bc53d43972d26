"""Verbs on published tables and figures."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from tactogram.cli.printing import Printer, columns, text_of
from tactogram.cli.verbs import Verb
from tactogram.workflows.request import Argument, Option, Request
from tactogram.workflows.worker_options import ON


@dataclass(frozen=True)
class _ReproduceRequest(Request):
    name: Annotated[str | None, Argument(metavar="EXPERIMENT")] = None
    data: Annotated[
        str, Option("store to run it on (default: simulated data of the published layout)", "DIR")
    ] = ""
    recipe: Annotated[str, Option("bench (hours at most on 2 cores) or paper")] = "bench"
    options: Annotated[
        Mapping[str, Any] | None,
        Option("option of the experiment, e.g. model=ar_texture", "KEY=VALUE", "--set"),
    ] = None
    out: Annotated[
        str | None,
        Option(
            "folder for its results (default runs/EXPERIMENT); results of an interrupted or smaller run are reused",
            "DIR",
        ),
    ] = None
    on: Annotated[str, ON] = ""
    processes: Annotated[
        int | None,
        Option(
            "processes for independent trainings (default: one after the other, on all cores)", "N", least=1
        ),
    ] = None


@dataclass(frozen=True)
class _TableRequest(Request):
    pass


def _reproduce(request: _ReproduceRequest, show: Printer) -> None:
    if request.name is None:
        _experiments(show)
        return
    from tactogram.experiments.reproduce import reproduce

    with show.progress() as progress:
        result = reproduce(**vars(request) | {"progress": progress})
    show(result, result["text"])


def _experiments(show: Printer) -> None:
    from tactogram.experiments.catalogue import data_text, experiments, header_of, result_files

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


def _table(request: _TableRequest, show: Printer) -> None:
    from tactogram.workflows.table import table

    rows = table()
    cells = [(r["model"], r["what"], text_of(r["published"]), text_of(r["ours"]), r["data"]) for r in rows]
    show({"rows": rows}, columns([("model", "what", "published", "ours", "our data"), *cells]))


VERBS = {
    "reproduce": Verb(_ReproduceRequest, _reproduce, listing=("list the experiments", _experiments)),
    "table": Verb(_TableRequest, _table, folders=("models",)),
}
