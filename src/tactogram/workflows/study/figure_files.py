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

    Only a file whose SHA-256 the earlier one gave goes: what was changed since, a link, and whatever an analysis
    without such numbers names, may be somebody's own and stays.

    Parameters
    ----------
    folder : Path
    listed : str
        Name of the earlier analysis's JSON there.
    kept : collection of str
        Names that are about to be written.
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
        except (OSError, ValueError):  # no such file, or no name of a file; not ours to remove
            continue
    return removed


def _earlier(path: Path) -> dict[str, Any]:
    """Return what an analysis says are the SHA-256 of its figures; none where it is none, or broken."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    known = found.get(HASHES) if isinstance(found, dict) and "sections" in found else None
    return known if isinstance(known, dict) else {}
