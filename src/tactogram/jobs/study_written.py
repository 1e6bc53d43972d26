"""Figures that an earlier analysis left in a folder: they go before another is written, what others put there stays."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

HASHES = "sha256"
"""Key of an analysis's JSON: hexadecimal SHA-256 by the name of each figure."""


def hashes_of(figures: Mapping[str, bytes]) -> dict[str, str]:
    """Return the SHA-256 of each figure, by its file's name."""
    return {name: sha256(data).hexdigest() for name, data in figures.items()}


def remove_earlier(folder: Path, listed: str, *, kept: Collection[str]) -> list[str]:
    """Remove the figures of an earlier analysis that the next does not write, and return their names.

    Of those that the earlier one says it wrote, a figure that was changed since is somebody's own and stays.

    Parameters
    ----------
    folder : Path
    listed : str
        Name of the earlier analysis's JSON there.
    kept : collection of str
        Names that are about to be written.
    """
    earlier = _earlier(folder / listed)
    known = earlier.get(HASHES)
    known = known if isinstance(known, dict) else {}
    removed = []
    for name in earlier.get("files") or ():
        if not isinstance(name, str) or Path(name).name != name or not name.endswith(".png") or name in kept:
            continue
        path = folder / name
        if not path.is_file():
            continue
        digest = sha256(path.read_bytes()).hexdigest()
        if known.get(name, digest) == digest:  # an earlier version said names only
            path.unlink()
            removed.append(name)
    return removed


def _earlier(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    ours = isinstance(found, dict) and isinstance(found.get("files"), list) and "sections" in found
    return found if ours else {}
