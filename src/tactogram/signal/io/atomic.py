"""Atomic files, written beside their place and renamed; the check of a target before long work, and file locks."""

from __future__ import annotations

import os
import secrets
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactogram.errors import ParameterError


@contextmanager
def atomic_write(path: Path, *, durable: bool = False, over: bool = True) -> Iterator[Path]:
    """Yield a path of the same suffix whose file replaces ``path`` on success and is removed otherwise.

    Readers find the old file or the new one, complete; of several writers, the last one wins. The folder is made if
    missing. ``durable`` synchronises the file to the disk before it is renamed, so that it survives a power cut.
    Without ``over``, an existing file stays.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.stem[:40]}-{secrets.token_hex(4)}.part{path.suffix}")
    try:
        yield part
        if durable:
            to_disk(part)
        if over:
            part.replace(path)
        else:
            _take(part, path)
    finally:
        part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    r"""Write ``text`` to ``path`` in UTF-8, atomically; bytes of file names that are not UTF-8 become ``\udcff``."""
    with atomic_write(path) as part:
        part.write_text(text, encoding="utf-8", errors="backslashreplace")


def to_disk(*paths: Path) -> None:
    """Synchronise files and folders to the disk (fsync), so that they survive a power cut."""
    for path in paths:
        if os.name == "nt" and path.is_dir():  # cannot be opened there; the file system sees to it
            continue
        opened = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def _take(part: Path, path: Path) -> None:
    """Rename a file, unless the name is taken."""
    try:
        os.link(part, path)
    except FileExistsError:
        return
    except OSError:  # a file system without links
        part.replace(path)


def check_writable(path: Path, *, folder: bool = False) -> None:
    """Raise a `ParameterError` if a file, or with ``folder`` a folder of files, cannot be written to a path.

    Permissions are not sufficient (a file system may be read-only, a network share may have its own), so an unnamed
    file is opened in the nearest existing folder; nothing is left there, and no folder is made.
    """
    if long := [part for part in path.parts if len(os.fsencode(part)) > 255]:
        raise ParameterError(f"{long[0]}: a name must have at most 255 bytes; give a shorter one")
    try:
        if folder and path.exists() and not path.is_dir():
            raise ParameterError(f"{path}: is a file; a folder is needed here: give another name")
        if not folder and path.is_dir():
            raise ParameterError(f"{path}: is a folder; a file is needed here: give another name")
        whole = path.absolute()
        there = next(base for base in ((whole, *whole.parents) if folder else whole.parents) if base.exists())
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        raise ParameterError(f"{path}: cannot be written ({error.strerror}); give another place") from error


def lock(opened: int, *, shared: bool = False) -> bool:
    """Lock the open file of a descriptor until it is closed, without waiting; return whether it is locked.

    A file that is opened twice is locked separately, even by one process. Other ``shared`` locks are allowed, except on
    Windows. A file system without locks raises an OSError.
    """
    # Each module exists on one kind of system only.
    if sys.platform == "win32":
        import msvcrt

        os.lseek(opened, 1 << 30, os.SEEK_SET)  # behind the end, since locked bytes cannot be read
        try:
            msvcrt.locking(opened, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        return True
    import fcntl

    try:
        fcntl.flock(opened, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
