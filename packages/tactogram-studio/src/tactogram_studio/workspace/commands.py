"""Equivalent commands of what pages do, and the names of what they write."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tactogram.cli.verbs import spelt


def arguments(*words: str, **options: Any) -> list[str]:
    """Return the words after ``tactogram``: options by parameter of the verb, with a value or one for each of a list.

    A flag for True; None, False and empty values are left out. Numbers read back as themselves.
    """
    parts = list(words)
    for name, value in options.items():
        option = spelt(name)
        if value is True:
            parts.append(option)
            continue
        entries = value if isinstance(value, list | tuple) else [value]
        for entry in map(assignments, entries) if isinstance(value, Mapping) else entries:
            if entry is not None and entry is not False and entry != "":
                parts += [option, entry if isinstance(entry, str) else exact(entry)]
    return parts


def command_line(arguments: Sequence[str]) -> str:
    """Return the shell command for ``arguments`` of ``tactogram``."""
    return shlex.join(["tactogram", *arguments])


def exact(value: float) -> str:
    """Return a number as text that reads back as itself."""
    return f"{value:g}" if float(f"{value:g}") == value else repr(float(value))


def assignments(values: Mapping[str, float]) -> str:
    """Return numbers by name as ``NAME=VALUE,…``."""
    return ",".join(f"{name}={exact(value)}" for name, value in values.items())


def free_name(folder: Path, name: str, suffix: str = "") -> str:
    """Return the first of ``name``, ``name-2``, ``name-3``, … (plus ``suffix``) that is unused in ``folder``."""
    number, free = 1, name + suffix
    while (folder / free).exists():
        number += 1
        free = f"{name}-{number}{suffix}"
    return free


def stem_of(title: str, otherwise: str = "touch") -> str:
    """Return a title as the name of a file without its suffix."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", title)[:40].strip("-") or otherwise
