"""Atomic files, written beside their place and renamed; the check of a target before long work, and file locks."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import socket
import sys
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from contextvars import ContextVar
from pathlib import Path

from tactogram.errors import ParameterError

_OWN: ContextVar[frozenset[str]] = ContextVar("own", default=frozenset())
"""Places of which this thread is the `sole_writer`."""


@contextmanager
def atomic_write(path: Path, *, durable: bool = False, over: bool = True) -> Iterator[Path]:
    """Yield a path of the same suffix whose file replaces ``path`` on success and is removed otherwise.

    Readers find the old file or the new one, complete; of several writers, the last one wins. The folder is made if
    missing, and an `OSError` names ``path``. ``durable`` synchronises the file to the disk before it is renamed, so
    that it survives a power cut. Without ``over``, an existing file stays.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    whose = f"{host_name()[:16]}-{os.getpid()}-{secrets.token_hex(4)}"
    part = path.with_name(f".{path.stem[:40]}-{whose}.part{path.suffix}")
    try:
        yield part
        if durable:
            to_disk(part)
        if over:
            part.replace(path)
        else:
            _take(part, path)
    except OSError as error:
        if error.filename in (None, str(part)):
            error.filename = str(path)
        raise
    finally:
        with suppress(OSError):  # such as of a folder that cannot be written, or a part that was renamed
            part.unlink()


def clear_parts(path: Path) -> None:
    """Remove what killed processes of this machine were writing in a folder, or beside a file."""
    for part in path.rglob(".*.part*") if path.is_dir() else path.parent.glob(".*.part*"):
        whose = re.search(rf"-{re.escape(host_name()[:16])}-(\d+)-[0-9a-f]{{8}}\.part", part.name)
        if whose and not is_running(int(whose[1])):
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


@contextmanager
def sole_writer(path: Path) -> Iterator[None]:
    """Refuse to write to ``path`` while another process of this user and machine does, with a `ParameterError`.

    What its block calls may write there, and so may the further processes of a training on several devices. However
    that process ends, the system unlocks the place, and the next writer clears it (`clear_parts`).
    """
    place = hashlib.sha256(os.fsencode(os.path.realpath(path))).hexdigest()[:16]
    if place in (own := _OWN.get()) or os.environ.get("LOCAL_RANK", "0") != "0":
        yield
        return
    note = Path(tempfile.gettempdir()) / f"tactogram-writer-{place}"
    with ExitStack() as stack:
        with suppress(OSError):
            held = stack.enter_context(note.open("a+"))
            # A note without a name was that of a writer that ended since it was opened; there may be another.
            if not lock(held.fileno()) or not os.fstat(held.fileno()).st_nlink:
                held.seek(0)
                who = held.read() or "another process"
                raise ParameterError(f"{path}: {who} writes it at present; wait for it, or stop it first")
            if os.name != "nt":  # where open files stay
                stack.callback(note.unlink, missing_ok=True)
            held.truncate(0)
            held.write(f"process {os.getpid()}")
            held.flush()
            clear_parts(path)
        stack.callback(_OWN.set, own)
        _OWN.set(own | {place})
        yield


@contextmanager
def turn(folder: Path) -> Iterator[None]:
    """Wait until no other process has its turn in a folder; on Windows, and without locks, nothing is waited for."""
    if os.name == "nt":
        yield
        return
    opened = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            lock(opened, wait=True)
        yield
    finally:
        os.close(opened)


def lock(opened: int, *, shared: bool = False, wait: bool = False) -> bool:
    """Lock the open file of a descriptor until it is closed; return whether it is locked. On Windows it never waits.

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
        fcntl.flock(opened, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        return False
    return True


def host_name() -> str:
    """Return this machine's name as used in file names, since process numbers belong to one machine."""
    return re.sub(r"[^A-Za-z0-9]+", "_", socket.gethostname()) or "host"


def is_running(process: int) -> bool:
    """Return whether there is a process of this number on this machine."""
    if os.name == "nt":  # where signal 0 would end it
        import psutil

        return bool(psutil.pid_exists(process))
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
