"""Verbs on published tables and figures."""

from __future__ import annotations

from tactogram.cli.options import Verbs, models_option
from tactogram.cli.printing import Arguments, columns, print_result, text_of


def add_verbs(verbs: Verbs) -> None:
    """Add what each verb takes."""
    add = verbs.add("reproduce", reproduce)
    add("experiment", metavar="EXPERIMENT", nargs="?")
    add("--list", action="store_true", help="list the experiments")
    add("--recipe", default="bench", help="bench (hours at most on 2 cores) or paper (default %(default)s)")
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="option of the experiment, e.g. model=ar_texture",
    )
    add(
        "--out",
        metavar="DIR",
        help="folder for its results (default runs/EXPERIMENT); results of an interrupted or smaller run are "
        "reused",
    )

    models_option(verbs.add("table", table))


def reproduce(a: Arguments) -> None:
    """Run the experiment behind a published table or figure."""
    from tactogram.experiments.catalogue import experiments

    if a.list or a.experiment is None:
        found = experiments()
        print_result(a, found, columns(list(found.items())))
        return
    from tactogram.experiments.reproduce import reproduce
    from tactogram.recipe import parse_changes
    from tactogram.workflows.progress import shown

    with shown() as progress:
        result = reproduce(
            a.experiment, recipe=a.recipe, out=a.out, options=parse_changes(a.set), progress=progress
        )
    print_result(a, result, result["text"])


def table(a: Arguments) -> None:
    """Show every model's published results beside ours."""
    from tactogram.workflows.table import table

    rows = table()
    shown_rows = [
        (r["model"], r["what"], text_of(r["published"]), text_of(r["ours"]), r["data"]) for r in rows
    ]
    print_result(
        a, {"rows": rows}, columns([("model", "what", "published", "ours", "our data"), *shown_rows])
    )
