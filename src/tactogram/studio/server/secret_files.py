"""Files of secrets: the whole file or none, readable by its owner only."""

from __future__ import annotations

import os
import secrets
from pathlib import Path


def write_secret(path: Path, data: bytes, *, over: bool = False) -> None:
    """Write a file of secrets.

    Parameters
    ----------
    path : Path
        In a folder that is there.
    data : bytes
    over : bool
        Whether it takes the place of a file that is there. Else that stays: another process was first.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    part = path.with_name(f".{path.stem}-{secrets.token_hex(4)}.part")
    try:
        with os.fdopen(os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600), "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        if over:
            part.replace(path)
        else:
            _take(part, path)
    finally:
        part.unlink(missing_ok=True)


def _take(part: Path, path: Path) -> None:
    """Give a file its name, unless the name is taken."""
    try:
        os.link(part, path)
    except FileExistsError:
        return
    except OSError:  # a file system without links
        part.replace(path)
