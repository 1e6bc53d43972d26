"""Argument parser of all verbs. Nothing heavy is imported before a verb is chosen."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

from tactogram.cli import (
    actuating,
    capture_log,
    capturing,
    data,
    files,
    generating,
    recognising,
    rendering,
    reproducing,
    start,
    streaming,
    studio,
    studying,
    training,
)
from tactogram.cli.options import Verbs

GROUPS = (
    start,
    data,
    training,
    generating,
    recognising,
    files,
    rendering,
    actuating,
    streaming,
    capturing,
    capture_log,
    studying,
    studio,
    reproducing,
)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of every verb; what it parses has ``run``, the function to call."""
    parser = argparse.ArgumentParser(
        prog="tactogram",
        description="Learn, generate, judge and render touch.",
        epilog="Results are on stdout, progress on stderr. `tactogram VERB --help` says what a verb takes.",
    )
    parser.add_argument("--version", action=_Version, help="show the version and exit")
    verbs = Verbs(parser, metavar="VERB")
    for group in GROUPS:
        group.add_verbs(verbs)
    return parser


class _Version(argparse.Action):
    """Show the version without looking it up for every other command."""

    def __init__(self, option_strings: Sequence[str], dest: str, **kwargs: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **kwargs)

    def __call__(self, parser: argparse.ArgumentParser, *_: Any) -> None:
        from importlib.metadata import version

        sys.stdout.write(f"tactogram {version('tactogram')}\n")
        parser.exit()
