"""Log of what was played on a device, a line each, in ``played.jsonl``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any


def log_played(folder: Path, facts: Mapping[str, Any]) -> None:
    """Add a line to ``played.jsonl``: what was played, by hash, how strong and where."""
    folder.mkdir(parents=True, exist_ok=True)
    line = json.dumps({"time": datetime.now(UTC).isoformat(timespec="seconds"), **facts}, ensure_ascii=False)
    with (folder / "played.jsonl").open("a", encoding="utf-8") as file:
        file.write(line + "\n")


def played_lately(folder: Path, count: int = 5) -> list[dict[str, Any]]:
    """Return what was played last, newest first."""
    try:
        lines = (folder / "played.jsonl").read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    found = []
    for line in reversed(lines[-4 * count :]):
        try:
            found.append(json.loads(line))
        except ValueError:  # cut short by a kill
            continue
    return found[:count]
