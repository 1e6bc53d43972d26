"""Command ``tactogram``: one verb, its result, and one line for an error."""

from __future__ import annotations

import io
import os
import sys
import warnings
from collections.abc import Sequence
from importlib import import_module

from tactogram.cli.catalogue import group_helps, nearest_verb, overview, verb_places
from tactogram.cli.hints import in_words
from tactogram.cli.verbs import flags_of, run
from tactogram.errors import StoppedError, TactogramError

# torch's threads spin when they wait, and collapse when a core is busy. Read when torch is imported.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


def main(argv: Sequence[str] | None = None) -> int:
    r"""Run one verb; return its exit status, 1 after a line on stderr for an error.

    Wrong usage returns 2, an interrupted verb 130. File names that are not UTF-8 are decoded by Python as surrogates;
    stdout and stderr show these as ``\udcff``, which JSON reads back.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    # In a process of its own libraries' warnings are for developers.
    if argv is None and not sys.warnoptions:
        warnings.simplefilter("ignore")
    words = list(sys.argv[1:] if argv is None else argv)
    places = verb_places()
    chosen = next((verb for count in (1, 2) if (verb := " ".join(words[:count])) in places), "")
    if not chosen:
        return _without_verb(words)
    verb = import_module(places[chosen].module).VERBS[chosen]
    try:
        return run(chosen, verb, words[chosen.count(" ") + 1 :])
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except StoppedError as error:
        message, status = str(error), 130
    except KeyboardInterrupt:
        message, status = "interrupted", 130
    except TactogramError as error:
        message, status = in_words(error, flags_of(verb), words), 1
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


def _without_verb(words: Sequence[str]) -> int:
    """Answer a command that names no verb: version, help, or what was probably meant."""
    if "--version" in words[:1]:
        from importlib.metadata import version  # takes longer than the rest of this module

        sys.stdout.write(f"tactogram {version('tactogram')}\n")
        return 0
    group = words[0] if words and words[0] in group_helps() else ""
    asked = {"-h", "--help"} & set(words)
    if unknown := nearest_verb(words, verb_places()):
        sys.stderr.write(f"tactogram: {unknown}\n")
        return 2
    (sys.stdout if asked else sys.stderr).write(overview(group))
    return 0 if asked else 2
