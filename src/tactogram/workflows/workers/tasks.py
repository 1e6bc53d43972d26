"""Tasks by this process, by several, or by Ray: the same results; each kept in a file, if a killed job should go on."""

from __future__ import annotations

import json
import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, Generic, TypeVar

from tactogram.errors import ParameterError, TactogramError
from tactogram.main_script import allowed_processes, start_worker
from tactogram.signal.io.atomic import write_text
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.workers.one_task import ATTEMPTS, ONE_THREAD, Attempt, attempted

T = TypeVar("T")
R = TypeVar("R")


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
        write_text(file_of[name(outcome.task)], json.dumps(outcome.value) + "\n")
    return [json.loads(file.read_text(encoding="utf-8")) for file in files]


def _counted(
    progress: ProgressCallback, title: str, task: str, done: int, total: int, note: str = ""
) -> None:
    """Show the tasks under the title of the whole."""
    progress(title, done, total, note)


@dataclass(frozen=True)
class Outcome(Generic[T, R]):
    """Result of a task."""

    task: T
    """As given."""
    value: R | None
    """What the function returned."""
    error: str | None
    """One line; None if it succeeded."""


def run_tasks(
    function: Callable[[T], R],
    tasks: Sequence[T],
    *,
    on: str = "",
    name: Callable[[T], str] = str,
    processes: int = 1,
    progress: ProgressCallback = silent,
) -> Iterator[Outcome[T, R]]:
    """Yield the outcome of each task as it is done, in any order.

    Every task runs on one thread. A `TactogramError` is the task's outcome; any other exception ends all. What is lost
    when a worker or node dies is done again, up to `ATTEMPTS` times. Nothing is kept: a caller that writes the values
    to files and leaves out the tasks whose files exist goes on where it was killed.

    Raises `ParameterError` for another ``on``, or an address at which no cluster answers; `MissingExtraError` if Ray is
    not installed; `TactogramError` if processes of this machine die again and again.

    Parameters
    ----------
    function : callable
        Of a module, as workers import it; like tasks and values it is pickled.
    on : str
        ``""``: this machine; ``"ray"``: a Ray started here, or the one that this process is connected to;
        ``"ray:ADDRESS"``: a cluster.
    name : callable
        Returns the name of a task, for ``progress``.
    processes : int
        Of this machine: 1 is this process itself. Of a Ray started here, 1 is one per core. A cluster has its own.
    """
    engine, _, address = on.partition(":")
    if engine not in ("", "ray") or (on and on != "ray" and not address):
        raise ParameterError.must("on", "be ray or ray:ADDRESS", on)
    if processes < 1:
        raise ParameterError.must("processes", "be at least 1", processes)
    if engine:
        from tactogram.workflows.workers.ray_cluster import on_ray

        attempts = on_ray(function, tasks, address, processes)
    elif allowed_processes(processes, 1) == 1:
        attempts = ((task, attempted(function, task)) for task in tasks)
    else:
        attempts = _in_processes(function, tasks, processes)
    return _outcomes(attempts, len(tasks), name, progress)


def _outcomes(
    attempts: Iterator[tuple[T, Attempt[R]]],
    total: int,
    name: Callable[[T], str],
    progress: ProgressCallback,
) -> Iterator[Outcome[T, R]]:
    for done, (task, (value, error)) in enumerate(attempts, start=1):
        progress("tasks", done, total, name(task))
        yield Outcome(task, value, error)


def _in_processes(
    function: Callable[[T], R], tasks: Sequence[T], processes: int
) -> Iterator[tuple[T, Attempt[R]]]:
    """Yield each task with its attempt, as they end; few wait at a time, so that memory stays flat."""
    left = deque(tasks)
    context = get_context("spawn")
    for _ in range(ATTEMPTS):
        running: dict[Future[Attempt[R]], T] = {}
        ends, ended = context.Pipe(duplex=False)  # closing it ends the processes, whatever they do
        pool = ProcessPoolExecutor(processes, mp_context=context, initializer=_begin, initargs=(ends,))
        try:
            while True:
                while left and len(running) < 2 * processes:
                    future = pool.submit(attempted, function, left[0])
                    running[future] = left.popleft()
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    attempt = future.result()
                    yield running.pop(future), attempt
        except BrokenProcessPool:
            left.extendleft(running.values())
        finally:
            ended.close()
            pool.shutdown(cancel_futures=True)
            ends.close()
    raise TactogramError(
        f"workers died {ATTEMPTS} times; the system may have run out of memory: ask for fewer processes"
    )


def _begin(ends: Connection) -> None:
    os.environ |= ONE_THREAD
    start_worker(ends)


def in_order(outcomes: Iterable[Outcome[tuple[int, T], R]]) -> Iterator[Outcome[tuple[int, T], R]]:
    """Yield the outcomes of tasks numbered from 0 in the order of their numbers, each as soon as it can be."""
    waiting: dict[int, Outcome[tuple[int, T], Any]] = {}
    following = 0
    for outcome in outcomes:
        waiting[outcome.task[0]] = outcome
        while following in waiting:
            yield waiting.pop(following)
            following += 1


def absolute(place: Path | str) -> str:
    """Return a path as workers in other folders find it; an address such as ``s3://store`` stays as it is."""
    return str(place) if "://" in str(place) else str(Path(place).absolute())
