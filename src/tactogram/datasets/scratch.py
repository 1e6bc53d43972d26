"""Folders for what is prepared while a process runs; those that a killed one left go when the next one is made."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tactogram.signal.io.locks import lock

PREFIX = "tactogram-prepared-"
HELD = "held"
"""Locked as long as the folder is used."""
YOUNGEST_S = 3600.0
"""A folder that changed since is nobody's leftover, even if it is not held: its process may be about to."""


@contextmanager
def scratch() -> Iterator[Path]:
    """Give a new folder, and remove it with all that is in it."""
    path, held = _made()
    try:
        yield path
    finally:
        _remove(path, held)


def scratch_of(owner: object) -> Path:
    """Return a new folder that goes when ``owner`` does."""
    path, held = _made()
    weakref.finalize(owner, _remove, path, held)
    return path


def _made() -> tuple[Path, int]:
    """Return a new folder and what holds it, once those that killed processes left are gone."""
    _clear(Path(tempfile.gettempdir()))
    path = Path(tempfile.mkdtemp(prefix=PREFIX))
    held = os.open(path / HELD, os.O_CREAT | os.O_RDWR, 0o600)
    with suppress(OSError):  # no locks there: what a kill leaves then stays
        lock(held)
    return path, held


def _remove(path: Path, held: int) -> None:
    os.close(held)
    shutil.rmtree(path, ignore_errors=True)


def _clear(folder: Path) -> None:
    """Remove the folders in ``folder`` that nobody holds any more; those of other users cannot be opened and stay."""
    for path in folder.glob(f"{PREFIX}*"):
        try:
            if time.time() - path.stat().st_mtime < YOUNGEST_S:
                continue
            held = os.open(path / HELD, os.O_RDWR)
        except OSError:
            continue
        try:
            left = lock(held)
        except OSError:
            left = False
        finally:
            os.close(held)
        if left:
            shutil.rmtree(path, ignore_errors=True)
