"""Kinds of messages: one line for all files of which the same is said."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

MOST_NAMES = 3
_VARIES = re.compile(r"'[^']*'|\"[^\"]*\"|[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def by_kind(messages: Iterable[tuple[str, str]]) -> list[dict[str, Any]]:
    """Return what is said of files (name, message), each kind once: ``text``, ``count`` and ``files``, the first ones.

    Messages are alike but for names of files, numbers and what is quoted. The text of several is that of the first
    without its file's name.
    """
    found: dict[str, dict[str, Any]] = {}
    for name, message in messages:
        plain = _without(message, name)
        key = _VARIES.sub("#", plain)
        kind = found.setdefault(key, {"text": plain, "count": 0, "files": []})
        kind["count"] += 1
        if len(kind["files"]) < MOST_NAMES and name not in kind["files"]:
            kind["files"].append(name)
    return list(found.values())


def in_one_line(kind: dict[str, Any]) -> str:
    """Return a kind with the number of its messages and the names of its first files."""
    files, count = ", ".join(kind["files"]), kind["count"]
    if count == 1:
        return f"{files}: {kind['text']}" if files else str(kind["text"])
    what = "parts" if "#" in files else "files"
    return f"{count} {what}: {kind['text']} ({files}{', …' * (count > len(kind['files']))})"


def _without(message: str, name: str) -> str:
    """Return a message without the name of its file, whole or at the end of a path, at its beginning."""
    plain = name.partition("#")[0]
    return re.sub(rf"^(?:\S.*?/)?{re.escape(plain)}(?:#\w+)?:\s*", "", message) if plain else message
