"""Progress reports: a callback, and on a terminal a bar with the time left."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol, TextIO

if TYPE_CHECKING:
    from rich.console import Console

LEAST_S = 10.0
"""Time between two lines where stderr is not a terminal, s; `VARIABLE` replaces it."""
VARIABLE = "TACTOGRAM_PROGRESS_S"
"""Environment variable that the studio sets for trainings whose lines it reads."""


class ProgressCallback(Protocol):
    """Shows that ``done`` of ``total`` parts of ``task`` are done, with a short note."""

    def __call__(self, task: str, done: int, total: int, note: str = "") -> None:
        """Show it."""
        ...


def silent(task: str, done: int, total: int, note: str = "") -> None:
    """Show nothing."""


def never() -> bool:
    """Return False: nothing stops the training."""
    return False


@contextmanager
def shown() -> Iterator[ProgressCallback]:
    """Show progress on stderr: a bar per task on a terminal, a few lines elsewhere."""
    if not sys.stderr.isatty():
        yield ProgressLines(sys.stderr, float(os.environ.get(VARIABLE, LEAST_S)))
        return
    from rich.console import Console

    with progress_bars(Console(stderr=True)) as progress:
        yield progress


@contextmanager
def progress_bars(console: Console) -> Iterator[ProgressCallback]:
    """Show a bar per task on a console; a note takes the rest of its width, and is cut there."""
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.table import Column

    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}", table_column=Column(ratio=1, no_wrap=True, overflow="ellipsis")),
    )
    with Progress(*columns, console=console, expand=True) as bars:
        tasks: dict[str, Any] = {}

        def show(task: str, done: int, total: int, note: str = "") -> None:
            if task not in tasks:
                tasks[task] = bars.add_task(task, total=total, note=note)
            bars.update(tasks[task], completed=done, total=total, note=note)

        yield show


class ProgressLines:
    """A line each tenth of a task, but at most one each ``least_s``, and at the end of each task.

    The ends of a task that is repeated are at least ``least_s`` apart, too. ``clock`` returns the time, s.
    """

    def __init__(
        self, out: TextIO, least_s: float = LEAST_S, *, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._out, self._least_s, self._clock = out, least_s, clock
        self._last_s = clock()
        self._tenths: dict[str, int] = {}
        self._ended: set[str] = set()

    def __call__(self, task: str, done: int, total: int, note: str = "") -> None:
        """Write a line if one is due."""
        tenth, now_s = 10 * done // max(total, 1), self._clock()
        first_end = done >= total and task not in self._ended
        another = tenth != self._tenths.get(task) and now_s - self._last_s >= self._least_s
        if first_end or another:
            self._tenths[task], self._last_s = tenth, now_s
            self._ended |= {task} if done >= total else set()
            self._out.write(f"{task}: {done}/{total} {note}".rstrip() + "\n")
            self._out.flush()
