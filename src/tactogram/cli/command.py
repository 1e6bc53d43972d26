"""Command ``tactogram``: one verb, its result, and one line for an error."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from tactogram.cli.functions import FunctionVerb, run
from tactogram.cli.hints import nearest_verb, with_command, with_nearest
from tactogram.cli.parser import make_parser, verb_places
from tactogram.errors import StoppedError, TactogramError

# torch's threads spin when they wait, and collapse when a core is busy. Read when torch is imported.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


def main(argv: Sequence[str] | None = None) -> int:
    r"""Run one verb; return its exit status, 1 after a line on stderr for an error.

    Usage errors exit with 2, as argparse does; an interrupted verb returns 130. File names that are not UTF-8 are
    decoded by Python as surrogates; stdout and stderr show these as ``\udcff``, which JSON reads back.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    words = sys.argv[1:] if argv is None else argv
    parser = make_parser(words)
    if unknown := nearest_verb(words, places := verb_places()):
        parser.error(unknown)
    chosen = next((verb for count in (1, 2) if (verb := " ".join(words[:count])) in places), "")
    declared: Any = import_module(places[chosen].module).VERBS[chosen] if chosen else None
    arguments = argparse.Namespace() if isinstance(declared, FunctionVerb) else parser.parse_args(words)
    try:
        if isinstance(declared, FunctionVerb):
            return run(chosen, declared, words[chosen.count(" ") + 1 :])
        return _run(arguments)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except StoppedError as error:
        message, status = str(error), 130
    except KeyboardInterrupt:
        message, status = "interrupted", 130
    except TactogramError as error:
        message, status = _in_options(str(error), declared, words), 1
    except OSError as error:
        # No permission, no space, a file where a folder is needed: the system's words say enough.
        message, status = str(error), 1
    except MemoryError as error:
        message, status = f"not enough memory: {error or 'take less at once'}", 1
    except UnicodeEncodeError as error:
        if error.reason != "surrogates not allowed":
            raise
        message, status = f"{error.object!r}: file names must be UTF-8; rename the file or folder", 1
    except ValueError as error:
        if "embedded null" not in str(error):
            raise
        message, status = "a path holds a null byte; give one without", 1
    sys.stderr.write(f"tactogram: {message}\n")
    return status


def _run(arguments: argparse.Namespace) -> int:
    from tactogram.cli.folders import FOLDERS, further_folders
    from tactogram.cli.printing import Printer
    from tactogram.cli.verbs import UsageError, request_of

    verb, show = arguments.verb, Printer(json=arguments.json, quiet=arguments.quiet)
    if getattr(arguments, "list", False):
        verb.listing[1](show)
        return 0
    further_folders({option: getattr(arguments, option, ()) for option in FOLDERS})
    if out := getattr(arguments, "out", None) or getattr(arguments, "table", None):
        _check_out(out)
    try:
        return verb.run(request_of(verb, arguments), show) or 0
    except UsageError as error:
        arguments.usage_error(str(error))
        return 2


def _in_options(message: str, verb: Any, words: Sequence[str]) -> str:
    from tactogram.cli import functions, verbs

    flags = functions.flags_of(verb) if isinstance(verb, FunctionVerb) else verbs.flags_of(verb)
    return with_nearest(with_command(verbs.with_options(message, flags), words))


def _check_out(out: str) -> None:
    """Refuse an ``--out`` that cannot be written, whatever the verb: its results may take hours to compute."""
    from pathlib import Path

    from tactogram.signal.io.atomic import check_writable

    check_writable(Path(out), folder=Path(out).is_dir())
