"""Scratch folders for prepared data, removed after use; a new one also removes those that killed processes left."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tactogram.signal.io.atomic import host_name, lock

LOCK_FILE = "held"
"""File that is locked as long as the folder is used."""
YOUNGEST_S = 3600.0
"""Folders that changed within this time are left alone, even without a lock: their process may be about to lock."""


def prefix() -> str:
    """Return the prefix of this machine's folders: across machines that share a file system, locks may mean nothing."""
    return f"tactogram-prepared-{host_name()}-"


@contextmanager
def scratch() -> Iterator[Path]:
    """Yield a new folder, and remove it with its content."""
    path, descriptor = _new_folder()
    try:
        yield path
    finally:
        _remove(path, descriptor)


def scratch_of(owner: object) -> Path:
    """Return a new folder that is removed with ``owner``."""
    path, descriptor = _new_folder()
    weakref.finalize(owner, _remove, path, descriptor)
    return path


def _new_folder() -> tuple[Path, int]:
    """Return a new folder and the descriptor of its lock, after clearing leftovers."""
    _clear(Path(tempfile.gettempdir()))
    path = Path(tempfile.mkdtemp(prefix=prefix()))
    descriptor = os.open(path / LOCK_FILE, os.O_CREAT | os.O_RDWR, 0o600)
    with suppress(OSError):  # without locks, leftovers stay
        lock(descriptor)
    return path, descriptor


def _remove(path: Path, descriptor: int) -> None:
    os.close(descriptor)
    shutil.rmtree(path, ignore_errors=True)


def _clear(folder: Path) -> None:
    """Remove unlocked folders in ``folder``; those of other users cannot be opened and stay."""
    for path in folder.glob(f"{prefix()}*"):
        try:
            if time.time() - path.stat().st_mtime < YOUNGEST_S:
                continue
            # Created if missing: a process that was removing the folder was killed, too.
            descriptor = os.open(path / LOCK_FILE, os.O_CREAT | os.O_RDWR, 0o600)
        except OSError:
            continue
        try:
            abandoned = lock(descriptor)
        except OSError:
            abandoned = False
        finally:
            os.close(descriptor)
        if abandoned:
            shutil.rmtree(path, ignore_errors=True)
