"""Atomic files: written under a name of their own beside their place, then renamed."""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def atomic_write(path: Path, *, durable: bool = False, over: bool = True) -> Iterator[Path]:
    """Give a path to write to, which takes the place of ``path`` if all goes well and is removed if not.

    Readers find the old file or the new one, each whole. Of several writers, each writes a file of its own and the last
    one stays.

    Parameters
    ----------
    path : Path
        Its folder is made if it is not there. The path that is given has the same suffix.
    durable : bool
        Whether the file is on the disk itself (fsync) before it is renamed, so that a power cut leaves a whole one.
    over : bool
        Whether it takes the place of a file that is there; otherwise that one stays.
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
    r"""Write ``text`` to ``path`` in UTF-8; the whole file or nothing.

    A surrogate, from a file name that is not UTF-8, is written as ``\udcff``, which JSON reads back.
    """
    with atomic_write(path) as part:
        part.write_text(text, encoding="utf-8", errors="backslashreplace")


def to_disk(*paths: Path) -> None:
    """Return when files and folders are on the disk itself (fsync): a power cut takes nothing of them."""
    for path in paths:
        if os.name == "nt" and path.is_dir():  # cannot be opened there; the file system sees to it
            continue
        opened = os.open(path, os.O_RDWR if os.name == "nt" else os.O_RDONLY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)


def _take(part: Path, path: Path) -> None:
    """Give a file its name, unless the name is taken."""
    try:
        os.link(part, path)
    except FileExistsError:
        return
    except OSError:  # a file system without links
        part.replace(path)
