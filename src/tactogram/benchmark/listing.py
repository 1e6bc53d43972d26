"""List of the tasks, with the state of their data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tactogram.benchmark.data import STORES_VARIABLE, find_store
from tactogram.benchmark.task import available_tasks
from tactogram.plugins import further_folders


def list_tasks(
    folder: Path | str = "runs/benchmark",
    stores: Sequence[Path | str] = (),
    task_folders: Sequence[Path | str] = (),
) -> dict[str, dict[str, Any]]:
    """Return ``title``, ``kind``, ``data``, ``simulated`` and ``state`` of each task by name.

    The state is ``available``, ``simulated on demand``, or ``missing``, with the name of its importer.
    """
    places = (Path(folder) / "stores", *further_folders(STORES_VARIABLE, stores))
    found = {}
    for name, task in available_tasks(task_folders).items():
        there = find_store(task, places) is not None
        missing = "simulated on demand" if task.data.simulated else f"missing: import {task.data.importer}"
        found[name] = {
            "title": task.title,
            "kind": task.kind,
            "data": task.data.what,
            "simulated": task.data.simulated,
            "state": "available" if there else missing,
        }
    return found
