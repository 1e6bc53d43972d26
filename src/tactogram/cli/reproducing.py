"""Verbs on published tables and figures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from tactogram.cli.printing import Printer, columns, text_of
from tactogram.cli.verbs import Verb
from tactogram.workflows.request import Argument, Option, Request


@dataclass(frozen=True)
class _ReproduceRequest(Request):
    name: Annotated[str | None, Argument(metavar="EXPERIMENT")] = None
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


@dataclass(frozen=True)
class _TableRequest(Request):
    pass


def _reproduce(request: _ReproduceRequest, show: Printer) -> None:
    if request.name is None:
        _experiments(show)
        return
    from tactogram.experiments.reproduce import reproduce
    from tactogram.workflows.progress import shown

    with shown() as progress:
        result = reproduce(**vars(request) | {"progress": progress})
    show(result, result["text"])


def _experiments(show: Printer) -> None:
    from tactogram.experiments.catalogue import experiments

    found = experiments()
    show(found, columns(list(found.items())))


def _table(request: _TableRequest, show: Printer) -> None:
    from tactogram.workflows.table import table

    rows = table()
    cells = [(r["model"], r["what"], text_of(r["published"]), text_of(r["ours"]), r["data"]) for r in rows]
    show({"rows": rows}, columns([("model", "what", "published", "ours", "our data"), *cells]))


VERBS = {
    "reproduce": Verb(_ReproduceRequest, _reproduce, listing=("list the experiments", _experiments)),
    "table": Verb(_TableRequest, _table, folders=("models",)),
}
