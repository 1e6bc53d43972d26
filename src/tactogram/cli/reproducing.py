"""Verbs on published tables and figures."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from pathlib import Path
from typing import Annotated, Any

from tactogram.cli.printing import Printer, columns, terminal_width, text_of
from tactogram.cli.verbs import Verb
from tactogram.workflows.request import ON, Argument, Option, Request


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
    runs: Annotated[Sequence[str], Argument("evaluated runs whose figures are listed first", "RUN")] = ()
    _: KW_ONLY
    model: Annotated[str, Option("only rows of models whose name contains this", "TEXT")] = ""
    data: Annotated[str, Option("only rows of data that contains this", "TEXT")] = ""
    figure: Annotated[str, Option("only rows of figures that contain this, e.g. distance", "TEXT")] = ""


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
    from tactogram.errors import ParameterError
    from tactogram.workflows.table import table

    chosen = {"model": request.model, "data": request.data, "what": request.figure}
    rows = [
        row
        for row in table(runs=request.runs)
        if all(text.casefold() in row[name].casefold() for name, text in chosen.items())
    ]
    if not rows:
        raise ParameterError("no row contains all of that; `tactogram table` lists every row")
    cells = [(r["model"], r["what"], text_of(r["published"]), text_of(r["ours"]), r["data"]) for r in rows]
    head = [("model", "what", "published", "ours", "our data")]
    show({"rows": rows}, columns(head + cells, width=terminal_width()))


VERBS = {
    "reproduce": Verb(_ReproduceRequest, _reproduce, listing=("list the experiments", _experiments)),
    "table": Verb(_TableRequest, _table, folders=("models",)),
}
