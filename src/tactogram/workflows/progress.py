"""Progress reports: a callback, and on a terminal a bar with the time left."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol


class ProgressCallback(Protocol):
    """Shows that ``done`` of ``total`` parts of ``task`` are done, with a short note."""

    def __call__(self, task: str, done: int, total: int, note: str = "") -> None:
        """Show it."""
        ...


def silent(task: str, done: int, total: int, note: str = "") -> None:
    """Show nothing."""


@contextmanager
def shown() -> Iterator[ProgressCallback]:
    """Show progress on stderr: a bar per task on a terminal, a line each tenth of a task elsewhere."""
    if not sys.stderr.isatty():
        yield _ProgressLines()
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as Bars

    columns = (
        TextColumn("{task.description:28}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Bars(*columns, console=Console(stderr=True)) as bars:
        tasks: dict[str, int] = {}

        def show(task: str, done: int, total: int, note: str = "") -> None:
            if task not in tasks:
                tasks[task] = bars.add_task(task, total=total, note=note)
            bars.update(tasks[task], completed=done, total=total, note=note)  # type: ignore[arg-type]

        yield show


class _ProgressLines:
    """A line on stderr at the beginning of a task and each tenth of it."""

    def __init__(self) -> None:
        self.tenths: dict[str, int] = {}

    def __call__(self, task: str, done: int, total: int, note: str = "") -> None:
        tenth = 10 * done // max(total, 1)
        if tenth != self.tenths.get(task):
            self.tenths[task] = tenth
            sys.stderr.write(f"{task}: {done}/{total} {note}".rstrip() + "\n")
            sys.stderr.flush()
