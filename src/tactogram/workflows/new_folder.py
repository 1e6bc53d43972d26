"""A new folder that appears whole or not at all."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from tactogram.datasets.store.pending import clear_stale_parts, part_folder
from tactogram.errors import RunError


@contextmanager
def new_folder(target: Path) -> Iterator[Path]:
    """Yield a private folder beside ``target``, which becomes ``target`` unless the block raises.

    Raises `RunError` if ``target`` exists.
    """
    if target.exists():
        raise RunError(f"{target}: exists already; choose another `out`")
    target.parent.mkdir(parents=True, exist_ok=True)
    clear_stale_parts(target)
    part = part_folder(target)
    shutil.rmtree(part, ignore_errors=True)  # of a killed process with the same number
    part.mkdir(mode=0o700)
    try:
        yield part
        part.chmod(0o755)
        part.rename(target)
    finally:
        shutil.rmtree(part, ignore_errors=True)
