"""Outcome of a task, and one attempt at it on one thread."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from threadpoolctl import threadpool_limits

from tactogram.errors import TactogramError, one_line

T = TypeVar("T")
R = TypeVar("R")

ATTEMPTS = 4
"""Workers that may die of one task; the task fails then."""
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_WAIT_POLICY": "PASSIVE",
}
"""Environment of a worker, for libraries that are loaded later."""


@dataclass(frozen=True)
class Outcome(Generic[T, R]):
    """Result of a task."""

    task: T
    """As given."""
    value: R | None
    """What the function returned."""
    error: str | None
    """One line; None if it succeeded."""
    seconds: float
    worker: str
    """``local-0``, or host, Ray node and process."""


@dataclass(frozen=True)
class Attempt(Generic[R]):
    """An `Outcome` without its task, as a worker sends it."""

    value: R | None
    error: str | None
    seconds: float
    worker: str = ""


def attempted(function: Callable[[T], R], task: T, worker: str = "") -> Attempt[R]:
    """Return what ``function`` made of a task on one thread; a `TactogramError` is its error."""
    started = time.monotonic()
    value, error = None, None
    with one_thread():
        try:
            value = function(task)
        except TactogramError as raised:
            error = str(raised) or one_line(raised)
    return Attempt(value, error, time.monotonic() - started, worker)


def died(worker: str) -> Attempt[Any]:
    """Return the last attempt at a task of which `ATTEMPTS` workers died."""
    reason = f"{ATTEMPTS} workers died while they did it; the system may have run out of memory"
    return Attempt(None, reason, 0.0, worker)


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the loaded numerical libraries to one thread, so that sums are taken in one order wherever they are."""
    torch = sys.modules.get("torch")
    before = torch.get_num_threads() if torch else 0
    with threadpool_limits(1):
        if torch:
            torch.set_num_threads(1)
        try:
            yield
        finally:
            if torch:
                torch.set_num_threads(before)
