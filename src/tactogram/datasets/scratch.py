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

from tactogram.datasets.store.pending import host_name
from tactogram.signal.io.locks import lock

HELD = "held"
"""Locked as long as the folder is used."""
YOUNGEST_S = 3600.0
"""A folder that changed since is nobody's leftover, even if it is not held: its process may be about to."""


def prefix() -> str:
    """Return how the names of this machine's folders begin.

    On a file system that several machines share, the locks of one may mean nothing to the others.
    """
    return f"tactogram-prepared-{host_name()}-"


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
    path = Path(tempfile.mkdtemp(prefix=prefix()))
    held = os.open(path / HELD, os.O_CREAT | os.O_RDWR, 0o600)
    with suppress(OSError):  # no locks there: what a kill leaves then stays
        lock(held)
    return path, held


def _remove(path: Path, held: int) -> None:
    os.close(held)
    shutil.rmtree(path, ignore_errors=True)


def _clear(folder: Path) -> None:
    """Remove the folders in ``folder`` that nobody holds any more; those of other users cannot be opened and stay."""
    for path in folder.glob(f"{prefix()}*"):
        try:
            if time.time() - path.stat().st_mtime < YOUNGEST_S:
                continue
            # Made where it is missing: whoever removed the folder was killed, too.
            held = os.open(path / HELD, os.O_CREAT | os.O_RDWR, 0o600)
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
