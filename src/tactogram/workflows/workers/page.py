"""Page of tasks: which are done, where and in what time, and what failed."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

from tactogram.evaluation.report import ReportSection, ReportTable, write_report
from tactogram.workflows.workers.outcome import Outcome

T = TypeVar("T")
R = TypeVar("R")

EVERY_S = 2.0
"""Least time between two versions of the page."""
RELOAD_S = 5
"""Time after which a browser reads the page again, until all is done."""


def followed(
    outcomes: Iterable[Outcome[T, R]],
    path: Path,
    tasks: Sequence[T],
    *,
    title: str,
    name: Callable[[T], str] = str,
    before: Sequence[str] = (),
    simulated: bool | str = False,
) -> Iterator[Outcome[T, R]]:
    """Yield the outcomes of ``tasks``, and write the page at ``path`` anew as they arrive.

    ``before`` are the names of tasks that an earlier process did. No two tasks have the same ``name``.
    """
    rows: dict[str, Row] = {one: (one, "done before", None, None, None) for one in before}
    rows |= {one: (one, "to do", None, None, None) for one in map(name, tasks)}
    written, finished = -EVERY_S, False

    def write() -> None:
        nonlocal written
        written = time.monotonic()
        _write(path, title, list(rows.values()), simulated, reload=not finished)

    try:
        write()
        for outcome in outcomes:
            state = "failed" if outcome.error else "done"
            one = name(outcome.task)
            rows[one] = (one, state, outcome.worker, round(outcome.seconds, 2), outcome.error)
            if time.monotonic() - written > EVERY_S:
                write()
            yield outcome
    finally:
        finished = True
        write()


Row = tuple[str, str, str | None, float | None, str | None]
"""Task, state, worker, seconds, error."""


def _write(path: Path, title: str, rows: Sequence[Row], simulated: bool | str, *, reload: bool) -> None:
    states = [state for _, state, *_ in rows]
    failed, todo = states.count("failed"), states.count("to do")
    summary = (
        f"{len(rows) - failed - todo} of {len(rows)} tasks done, {failed} failed, {todo} to do, "
        f"at {time.strftime('%Y-%m-%d %H:%M:%S')}."
    )
    by_worker: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        if row[2]:
            by_worker[row[2]].append(row)
    workers = [
        (worker, len(done), sum(row[1] == "failed" for row in done), sum(row[3] or 0.0 for row in done))
        for worker, done in sorted(by_worker.items())
    ]
    # Failures first: of thousands of tasks they are what one looks for.
    ordered = sorted(rows, key=lambda row: row[1] != "failed")
    tables: dict[str, tuple[tuple[str, ...], Sequence[Sequence[Any]]]] = {
        "Workers": (("worker", "tasks", "failed", "seconds"), workers),
        "Tasks": (("task", "state", "worker", "seconds", "error"), ordered),
    }
    write_report(
        path,
        title=title,
        summary=summary,
        simulated=simulated,
        sections=[ReportSection(name, [ReportTable(*table)]) for name, table in tables.items()],
        reload_s=RELOAD_S if reload else None,
    )
