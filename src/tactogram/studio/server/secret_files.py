"""Files of secrets: the whole file or none, readable by its owner only."""

from __future__ import annotations

import os
from pathlib import Path

from tactogram.signal.io.atomic import atomic_write


def write_secret(path: Path, data: bytes, *, over: bool = False) -> None:
    """Write a file of secrets.

    Parameters
    ----------
    path : Path
        Its folder is made if it is not there.
    data : bytes
    over : bool
        Whether it takes the place of a file that is there. Else that stays: another process was first.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    with atomic_write(path, durable=True, over=over) as part:
        opened = os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
        with os.fdopen(opened, "wb") as file:
            file.write(data)
