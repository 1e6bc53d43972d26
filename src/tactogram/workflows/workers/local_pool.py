"""Tasks in this process, or in processes of this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Generic, TypeVar

from tactogram.datasets.reading import start_worker
from tactogram.workflows.workers.outcome import ATTEMPTS, ONE_THREAD, Attempt, attempted, died

T = TypeVar("T")
R = TypeVar("R")


def in_process(function: Callable[[T], R], tasks: Sequence[T]) -> Iterator[tuple[int, Attempt[R]]]:
    """Yield the number of each task with its attempt, in order."""
    for number, task in enumerate(tasks):
        yield number, attempted(function, task, "local-0")


def in_processes(
    function: Callable[[T], R], tasks: Sequence[T], processes: int
) -> Iterator[tuple[int, Attempt[R]]]:
    """Yield the number of each task with its attempt, as they end.

    Each process has an executor of its own, so that one that dies takes nothing but its task with it.
    """
    todo = iter(range(len(tasks)))
    tried = [0] * len(tasks)
    places = [_Place[T, R](f"local-{n}") for n in range(min(processes, len(tasks)))]
    running: dict[Future[Attempt[R]], tuple[_Place[T, R], int]] = {}

    def start(place: _Place[T, R], number: int | None) -> None:
        if number is not None:
            tried[number] += 1
            running[place.submit(function, tasks[number])] = place, number

    try:
        for place in places:
            start(place, next(todo, None))
        while running:
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                place, number = running.pop(future)
                try:
                    attempt = future.result()
                except BrokenProcessPool:
                    place.restart()
                    if tried[number] < ATTEMPTS:
                        start(place, number)
                        continue
                    attempt = died(place.name)
                start(place, next(todo, None))
                yield number, attempt
    finally:
        for place in places:
            place.end()


class _Place(Generic[T, R]):
    """A process, and the one that follows if it dies."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.restart()

    def restart(self) -> None:
        """Have the next task start a new process, which ends when ``ended`` is closed."""
        context = get_context("spawn")
        self.ends, self.ended = context.Pipe(duplex=False)
        self.executor = ProcessPoolExecutor(1, mp_context=context, initializer=_begin, initargs=(self.ends,))

    def submit(self, function: Callable[[T], R], task: T) -> Future[Attempt[R]]:
        return self.executor.submit(attempted, function, task, self.name)

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self.ended.close()
        self.executor.shutdown(cancel_futures=True)
        self.ends.close()


def _begin(ends: Connection) -> None:
    os.environ |= ONE_THREAD
    start_worker(ends)
