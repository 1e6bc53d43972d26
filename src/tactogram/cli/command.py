"""Command ``tactogram``: one verb, its result, and one line for an error."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from tactogram.cli.parser import make_parser
from tactogram.errors import StoppedError, TactogramError

# torch's threads spin when they wait, and collapse when a core is busy. Read when torch is imported.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one verb; return 0, or 1 after a line on stderr where something was wrong.

    Usage errors exit with 2, as argparse does; what was interrupted, or asked to stop, with 130.
    """
    arguments = make_parser().parse_args(argv)
    for option in ("models", "designs"):
        if folders := getattr(arguments, option, None):
            # Whatever loads a run or a session finds them: it names its model or design, not where that lies.
            variable = f"TACTOGRAM_{option.upper()}"
            known = os.environ.get(variable)
            os.environ[variable] = os.pathsep.join([*folders, *([known] if known else [])])
    try:
        if out := getattr(arguments, "out", None):
            _check_out(out)
        return arguments.run(arguments) or 0
    except StoppedError as error:
        sys.stderr.write(f"tactogram: {error}\n")
        return 130
    except TactogramError as error:
        sys.stderr.write(f"tactogram: {error}\n")
        return 1
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        # No permission, no space, a file where a folder is needed: the system's words say enough.
        sys.stderr.write(f"tactogram: {error}\n")
        return 1
    except MemoryError as error:
        sys.stderr.write(f"tactogram: not enough memory: {error or 'take less at once'}\n")
        return 1
    except KeyboardInterrupt:
        sys.stderr.write("tactogram: interrupted\n")
        return 130


def _check_out(out: str) -> None:
    """Refuse an ``--out`` that cannot be written to, whatever the verb: what it makes may take hours."""
    from pathlib import Path

    from tactogram.signal.io.writable import check_writable

    check_writable(Path(out), folder=Path(out).is_dir())
