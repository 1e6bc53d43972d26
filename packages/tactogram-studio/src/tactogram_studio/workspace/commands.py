"""Equivalent commands of what pages do, and the names of what they write."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def arguments(*words: str, options: Mapping[str, Any]) -> list[str]:
    """Return the words after ``tactogram``: options with a value, a flag for True, one for each entry of a list.

    None, False and empty texts are left out. Numbers read back as themselves.
    """
    found = list(words)
    for option, value in options.items():
        if value is True:
            found.append(option)
            continue
        for entry in value if isinstance(value, list | tuple) else [value]:
            if entry is not None and entry is not False and entry != "":
                found += [option, entry if isinstance(entry, str) else exact(entry)]
    return found


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
