"""Run lock: one training per run folder at a time."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactogram.errors import RunError
from tactogram.signal.io.atomic import lock

HELD = "recipe.toml"
"""Locked during training: this file is written once, never replaced, and lasts as long as the run."""

TRIES, BETWEEN_S = 10, 0.02
"""Retries while another process briefly holds the lock to look."""


@contextmanager
def run_lock(folder: Path) -> Iterator[None]:
    """Lock a run's folder for this process; the system unlocks it however the process ends.

    Raises
    ------
    RunError
        If another process trains there.
    """
    with (folder / HELD).open("rb") as file:
        for left in reversed(range(TRIES)):
            if lock(file.fileno()):
                break
            if not left:
                raise taken(folder)
            time.sleep(BETWEEN_S)
        yield


def is_training(folder: Path) -> bool:
    """Return whether a process trains in a run's folder."""
    try:
        with (folder / HELD).open("rb") as file:
            return not lock(file.fileno(), shared=True)
    except OSError:
        return False


def taken(folder: Path) -> RunError:
    """Return the error for a run's folder in which another process trains."""
    return RunError(f"{folder}: another process trains here at present; wait for it, or stop it first")
