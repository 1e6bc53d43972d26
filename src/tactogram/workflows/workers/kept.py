"""Values of tasks, each kept in a file, so that a job that was killed goes on."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from tactogram.errors import TactogramError
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.workers.tasks import run_tasks

T = TypeVar("T")


def kept_values(
    function: Callable[[T], dict[str, Any]],
    tasks: Sequence[T],
    files: Sequence[Path],
    *,
    title: str,
    name: Callable[[T], str] = str,
    on: str = "",
    processes: int = 1,
    progress: ProgressCallback = silent,
) -> list[dict[str, Any]]:
    """Return the value of each task, in order, read from its file or computed and written there as JSON.

    ``title`` is the stage of ``progress``. Other parameters are those of `run_tasks`.

    Raises `TactogramError` at the first task that fails; the values so far stay in their files.
    """
    file_of = dict(zip(map(name, tasks), files, strict=True))
    todo = [task for task in tasks if not file_of[name(task)].is_file()]
    outcomes = run_tasks(
        function, todo, on=on, name=name, processes=processes, progress=partial(_counted, progress, title)
    )
    for outcome in outcomes:
        if outcome.error is not None:
            raise TactogramError(f"{name(outcome.task)}: {outcome.error}")
        file = file_of[name(outcome.task)]
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text(file, json.dumps(outcome.value) + "\n")
    return [json.loads(file.read_text(encoding="utf-8")) for file in files]


def _counted(
    progress: ProgressCallback, title: str, task: str, done: int, total: int, note: str = ""
) -> None:
    """Show the tasks under the title of the whole."""
    progress(title, done, total, note)
