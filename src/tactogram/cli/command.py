"""Command ``tactogram``: one verb, its result, and one line for an error."""

from __future__ import annotations

import argparse
import io
import os
import sys
from collections.abc import Sequence

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
    if unknown := nearest_verb(words, verb_places()):
        parser.error(unknown)
    arguments = parser.parse_args(words)
    try:
        return _run(arguments)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except StoppedError as error:
        message, status = str(error), 130
    except KeyboardInterrupt:
        message, status = "interrupted", 130
    except TactogramError as error:
        message, status = _in_options(str(error), arguments, words), 1
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
    from tactogram.cli.printing import Printer
    from tactogram.cli.verbs import FOLDERS, UsageError, request_of

    verb, show = arguments.verb, Printer(json=arguments.json, quiet=arguments.quiet)
    if getattr(arguments, "list", False):
        verb.listing[1](show)
        return 0
    for option in FOLDERS:
        if folders := getattr(arguments, option, None):
            # Whatever loads a run or a session finds its model or design by name here.
            variable = f"TACTOGRAM_{option.upper()}"
            known = os.environ.get(variable)
            os.environ[variable] = os.pathsep.join([*folders, *([known] if known else [])])
    if out := getattr(arguments, "out", None) or getattr(arguments, "table", None):
        _check_out(out)
    try:
        return verb.run(request_of(verb, arguments), show) or 0
    except UsageError as error:
        arguments.usage_error(str(error))
        return 2


def _in_options(message: str, arguments: argparse.Namespace, words: Sequence[str]) -> str:
    from tactogram.cli.verbs import with_options

    return with_nearest(with_command(with_options(message, arguments.verb), words))


def _check_out(out: str) -> None:
    """Refuse an ``--out`` that cannot be written, whatever the verb: its results may take hours to compute."""
    from pathlib import Path

    from tactogram.signal.io.writable import check_writable

    check_writable(Path(out), folder=Path(out).is_dir())
