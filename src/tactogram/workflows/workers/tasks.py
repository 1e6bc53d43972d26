"""Tasks done by this process, by processes of this machine, or by Ray: the same results to the bit."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, TypeVar

from tactogram.errors import ParameterError
from tactogram.main_script import allowed_processes
from tactogram.workflows.progress import ProgressCallback, silent
from tactogram.workflows.workers.local_pool import in_process, in_processes
from tactogram.workflows.workers.outcome import Outcome

T = TypeVar("T")
R = TypeVar("R")


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

    Every task runs on one thread. A `TactogramError` is the task's outcome; any other exception ends all. A task whose
    worker or node dies is done again, up to `ATTEMPTS` times. Nothing is kept: a caller that writes the values to files
    and leaves out the tasks whose files exist goes on where it was killed.

    Raises `ParameterError` for another ``on``, or an address at which no cluster answers; `MissingExtraError` if Ray is
    not installed.

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
        raise ParameterError(f"on must be ray or ray:ADDRESS, got {on!r}")
    if processes < 1:
        raise ParameterError(f"processes must be at least 1, got {processes}")
    if not engine:
        allowed_processes(processes, 1)
    return _outcomes(function, tasks, engine, address, name, processes, progress)


def _outcomes(
    function: Callable[[T], R],
    tasks: Sequence[T],
    engine: str,
    address: str,
    name: Callable[[T], str],
    processes: int,
    progress: ProgressCallback,
) -> Iterator[Outcome[T, R]]:
    if engine:
        from tactogram.workflows.workers.ray_cluster import on_ray

        ended = on_ray(function, tasks, address, processes)
    elif processes == 1:
        ended = in_process(function, tasks)
    else:
        ended = in_processes(function, tasks, processes)
    done = 0
    for number, attempt in ended:
        task, done = tasks[number], done + 1
        progress("tasks", done, len(tasks), name(task))
        yield Outcome(task, attempt.value, attempt.error, attempt.seconds, attempt.worker)


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
