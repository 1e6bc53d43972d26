"""Removal of an earlier analysis's figures from a folder, and of nothing else."""

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
    """Remove the figures of an earlier analysis that the next does not write (``kept``), and return their names.

    Only a file with the SHA-256 in the earlier analysis's JSON ``listed`` is removed: a changed file, a link, or a
    figure of an analysis without hashes stays, since a person may have made it.
    """
    removed = []
    for name, digest in _earlier(folder / listed).items():
        path = folder / name
        if Path(name).name != name or path.suffix != ".png" or name in kept:
            continue
        try:
            if not path.is_symlink() and sha256(path.read_bytes()).hexdigest() == digest:
                path.unlink()
                removed.append(name)
        except (OSError, ValueError):  # no such file, or an invalid name
            continue
    return removed


def _earlier(path: Path) -> dict[str, Any]:
    """Return the SHA-256 of an analysis's figures by name; none of a broken file."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    known = found.get(HASHES) if isinstance(found, dict) and "sections" in found else None
    return known if isinstance(known, dict) else {}
