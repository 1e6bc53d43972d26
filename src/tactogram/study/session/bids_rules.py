"""Rules that a BIDS ``beh`` folder keeps, checked without the official validator.

What of the specification (1.10, "Common principles", "Data set description", "Behavioral experiments") concerns such a
folder: names of files, required keys, tables without empty cells, sidecars that describe every column.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

LABEL = "[A-Za-z0-9]+"
FILE = re.compile(
    rf"sub-(?P<sub>{LABEL})(_ses-(?P<ses>{LABEL}))?_task-(?P<task>{LABEL})(_run-[0-9]+)?_(?P<suffix>beh|events)"
    r"\.(tsv|json)"
)
FREE = ("sourcedata", "derivatives", "code")
"""Folders that the specification leaves to their makers."""
TOP = ("dataset_description.json", "README", "participants.tsv", "participants.json", "CHANGES")


def problems(folder: Path) -> list[str]:
    """Return what is wrong with a BIDS folder of behaviour, one line each; [] if nothing is."""
    return list(_problems(folder))


def _problems(folder: Path) -> Iterator[str]:
    description = _json(folder / "dataset_description.json")
    if description is None:
        yield "dataset_description.json is missing or no JSON object"
    else:
        for key in ("Name", "BIDSVersion"):
            if not isinstance(description.get(key), str) or not description[key]:
                yield f"dataset_description.json lacks {key}"
    if not (folder / "README").is_file():
        yield "README is missing"
    listed: list[str] = []
    rows = _table(folder / "participants.tsv")
    if isinstance(rows, str):
        yield rows
    else:
        listed = [row[0] for row in rows[1:]]
        if rows[0][0] != "participant_id":
            yield f"participants.tsv: first column must be participant_id, is {rows[0][0]}"
        for code in listed:
            if not re.fullmatch(f"sub-{LABEL}", code):
                yield f"participants.tsv: {code!r} must be sub- with letters and digits"
        yield from _described(folder / "participants.tsv", rows[0])
    there = sorted(path.name for path in folder.iterdir() if path.is_dir())
    for name in there:
        if name not in (*listed, *FREE):
            yield f"{name} is not in participants.tsv"
    for path in sorted(folder.iterdir()):
        if path.is_file() and path.name not in TOP:
            yield f"{path.name}: no file that belongs at the top"
    for path in sorted(folder.glob("sub-*/**/*")):
        if path.is_file():
            yield from _file(path, folder)


def _file(path: Path, folder: Path) -> Iterator[str]:
    parts = path.relative_to(folder).parts
    named = FILE.fullmatch(path.name)
    if named is None:
        yield f"{path.name}: no name of a behavioural file"
        return
    expected = (f"sub-{named['sub']}", *([f"ses-{named['ses']}"] if named["ses"] else []), "beh")
    if parts[:-1] != expected:
        yield f"{path.name}: must lie in {'/'.join(expected)}, lies in {'/'.join(parts[:-1])}"
    if path.suffix == ".json":
        if _json(path) is None:
            yield f"{path.name}: no JSON object"
        return
    rows = _table(path)
    if isinstance(rows, str):
        yield rows
        return
    yield from _described(path, rows[0])
    if named["suffix"] == "events":
        if rows[0][:2] != ["onset", "duration"]:
            yield f"{path.name}: must begin with onset and duration, has {rows[0][:2]}"
            return
        for number, row in enumerate(rows[1:], 2):
            for cell in row[:2]:
                if cell != "n/a" and not re.fullmatch(r"-?\d+(\.\d+)?", cell):
                    yield f"{path.name}: row {number}: {cell!r} is no number of seconds"


def _described(path: Path, headings: list[str]) -> Iterator[str]:
    sidecar = _json(path.with_suffix(".json"))
    if sidecar is None:
        yield f"{path.name} lacks its sidecar"
        return
    for name in headings:
        if not isinstance(sidecar.get(name), dict) or not sidecar[name].get("Description"):
            yield f"{path.with_suffix('.json').name} does not describe {name}"


def _table(path: Path) -> list[list[str]] | str:
    try:
        lines = path.read_text(encoding="utf-8").split("\n")
    except (OSError, UnicodeDecodeError):
        return f"{path.name} is missing or no text"
    if lines[-1] != "" or len(lines) < 2:
        return f"{path.name}: must end with a line break"
    rows = [line.split("\t") for line in lines[:-1]]
    if len(set(rows[0])) != len(rows[0]):
        return f"{path.name}: columns must differ"
    for number, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            return f"{path.name}: row {number} has {len(row)} cells, not {len(rows[0])}"
        if any(cell == "" or cell != cell.strip() for cell in row):
            return f"{path.name}: row {number} has an empty cell or one with spaces around it; write n/a"
    return rows


def _json(path: Path) -> dict[str, Any] | None:
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return value if isinstance(value, dict) else None
