"""Atomic files: written beside their place under a temporary name, then renamed."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_write(path: Path, *, durable: bool = False, over: bool = True) -> Iterator[Path]:
    """Yield a path of the same suffix whose file replaces ``path`` on success and is removed otherwise.

    Readers find the old file or the new one, complete; of several writers, the last one wins. The folder is made if
    missing. ``durable`` synchronises the file to the disk before it is renamed, so that it survives a power cut.
    Without ``over``, an existing file stays.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.stem}-{secrets.token_hex(4)}.part{path.suffix}")
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
