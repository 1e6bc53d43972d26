"""Options that several verbs share, and the registration of verbs."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any, cast

from tactogram.cli.printing import Arguments

Add = Callable[..., Any]
Verb = Callable[[Arguments], int | None]


class Verbs:
    """The verbs of ``tactogram``, or those of one of its groups.

    Parameters
    ----------
    parser : argparse.ArgumentParser
        What they are added to.
    metavar : str
        What stands for them in the usage line; by default their names.
    shared : callable, optional
        Adds what each of them takes.
    """

    def __init__(
        self,
        parser: argparse.ArgumentParser,
        *,
        metavar: str | None = None,
        shared: Callable[[Add], None] | None = None,
    ) -> None:
        self._subparsers = parser.add_subparsers(metavar=metavar, required=True)
        self._named_by_all = metavar is None
        self._shared = shared

    def add(self, name: str, run: Verb) -> Add:
        """Add a verb that calls ``run``, whose docstring's first line is its help; return its ``add_argument``."""
        line = (run.__doc__ or "").partition("\n")[0]
        text = line[:1].lower() + line[1:].rstrip(".")
        sub = self._subparsers.add_parser(name, help=text, description=line)
        sub.set_defaults(run=run, usage_error=sub.error)
        sub.add_argument("--json", action="store_true", help="print one JSON object")
        if self._shared is not None:
            self._shared(cast(Add, sub.add_argument))
        if self._named_by_all:
            self._subparsers.metavar = "|".join(self._subparsers.choices)
        return cast(Add, sub.add_argument)

    def group(self, name: str, text: str, *, shared: Callable[[Add], None] | None = None) -> Verbs:
        """Add a verb with verbs of its own, such as ``data``; ``shared`` adds what each of them takes."""
        return Verbs(self._subparsers.add_parser(name, help=text), shared=shared)

    def parser(self, name: str) -> argparse.ArgumentParser:
        """Return the parser of a verb, for what ``add_argument`` cannot say."""
        return self._subparsers.choices[name]


def models_option(add: Add) -> None:
    """Add ``--models``."""
    add("--models", action="append", default=[], metavar="DIR", help="folder of further models")


def designs_option(add: Add) -> None:
    """Add ``--designs``."""
    add(
        "--designs", action="append", default=[], metavar="PATH", help="a file or folder with further designs"
    )


def training_options(add: Add, *, more_by: str = "", data_required: bool = True) -> None:
    """Add what `training_arguments` reads: the data, the recipe and the split."""
    add(
        "--data",
        required=data_required,
        metavar="DIR",
        help="store made by `data import` or `data simulate`",
    )
    add(
        "--recipe",
        default="quick",
        metavar="NAME|FILE",
        help="paper, quick, tiny or a TOML file (default quick)",
    )
    add("--set", action="append", default=[], metavar="KEY=VALUE", help="change a value of the recipe")
    add("--band", type=float, nargs=2, metavar=("LO", "HI"), help="pass band in Hz; as --set prepare.band=…")
    add(
        "--split",
        default="",
        metavar="last=N|all",
        help="keep the last N recordings of a class for testing, or none",
    )
    add(
        "--by",
        default="recording",
        help=f"unit of the split, never on two sides: recording, session, subject, material or condition{more_by}",
    )
    add(
        "--label",
        default="material",
        help="definition of a class, e.g. material+contactor (default %(default)s)",
    )
    add(
        "--where",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="use only matching recordings, e.g. material=cork|tile, or material=!cork for all others",
    )
    add("--accelerator", default="auto", help="auto, cpu, cuda or mps (default %(default)s)")
    models_option(add)


def signal_options(add: Add) -> None:
    """Add what `signal_arguments` reads: what a file of a signal does not say."""
    add("--unit", help="unit of the samples, where the file does not state it: m/s^2, m/s, m, N, V or 1")
    add("--rate", type=float, metavar="HZ", help="sampling rate, where the file does not state it")
    add("--axes", help="columns or channels to read, e.g. x,y,z")


def training_arguments(a: Arguments) -> dict[str, Any]:
    """Return what `training_options` took, as the jobs take it."""
    from pathlib import Path

    from tactogram.errors import ParameterError
    from tactogram.recipe import parse_changes

    changes = parse_changes(a.set)
    if a.band:
        changes["prepare.band"] = list(a.band)
    where = {}
    for text in a.where:
        key, sign, value = text.partition("=")
        if not sign:
            raise ParameterError(f"--where needs KEY=VALUE, got {text!r}")
        where[key] = value
    return {
        "recipe": a.recipe,
        "changes": changes,
        "split": a.split,
        "by": a.by,
        "label": a.label,
        "where": where,
        "accelerator": a.accelerator,
        "model_folders": [Path(folder) for folder in a.models],
    }


def signal_arguments(a: Arguments) -> dict[str, Any]:
    """Return what `signal_options` took, as `read_signal` takes it."""
    axes = tuple(name.strip() for name in a.axes.split(",")) if a.axes else None
    return {"unit": a.unit, "rate": a.rate, "axes": axes}
