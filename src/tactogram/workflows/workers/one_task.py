"""One task on one thread, as every worker does it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

from threadpoolctl import threadpool_limits

from tactogram.errors import TactogramError, one_line

T = TypeVar("T")
R = TypeVar("R")

Attempt = tuple[R | None, str | None]
"""What the function returned, or one line on why it failed."""
ATTEMPTS = 4
"""Times that a task is tried whose workers die."""
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_WAIT_POLICY": "PASSIVE",
}
"""Environment of a worker, for libraries that are loaded later."""


def attempted(function: Callable[[T], R], task: T) -> Attempt[R]:
    """Return what ``function`` made of a task on one thread; a `TactogramError` is its error."""
    with one_thread():
        try:
            return function(task), None
        except TactogramError as error:
            return None, str(error) or one_line(error)


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
