"""Files of secrets, written atomically and readable by their owner only."""

from __future__ import annotations

import os
from pathlib import Path

from tactogram.signal.io import atomic_write


def write_secret(path: Path, data: bytes, *, replace: bool = False) -> None:
    """Write a file of secrets and its folder; an existing file stays unless ``replace``: another process was first."""
    with atomic_write(path, durable=True, over=replace) as part:
        opened = os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
        with os.fdopen(opened, "wb") as file:
            file.write(data)
