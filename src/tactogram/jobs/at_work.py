"""Whether a process trains in a run's folder at present: two at once would ruin it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactogram.errors import RunError

HELD = "recipe.toml"
"""Locked while a process trains: written once, never replaced, and there as long as the run is."""


@contextmanager
def at_work(folder: Path) -> Iterator[None]:
    """Hold a run's folder for this process; the system lets go of it however the process ends.

    Raises
    ------
    RunError
        If another process trains there.
    """
    with (folder / HELD).open("rb") as file:
        if not _locked(file.fileno()):
            raise RunError(f"{folder}: another process trains here at present; wait for it, or stop it first")
        yield


def is_at_work(folder: Path) -> bool:
    """Say whether a process trains in a run's folder; no where there is no run."""
    try:
        with (folder / HELD).open("rb") as file:
            return not _locked(file.fileno(), shared=True)
    except OSError:
        return False


def _locked(file: int, *, shared: bool = False) -> bool:
    """Lock a file until it is closed, and say whether that went; on Windows nothing is locked."""
    if sys.platform == "win32":
        return True
    import fcntl

    try:
        fcntl.flock(file, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
