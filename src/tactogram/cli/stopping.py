"""Stop signals: the first Ctrl-C or SIGTERM ends a long verb in order, the second at once."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def catch_stop_signals() -> Iterator[Callable[[], bool]]:
    """Yield a function that is true after a stop signal; outside the main thread it never is."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    stopped = False
    before = {number: signal.getsignal(number) for number in SIGNALS}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def ask(number: int, frame: Any) -> None:
        nonlocal stopped
        stopped = True
        restore()

    for number in SIGNALS:
        signal.signal(number, ask)
    try:
        yield lambda: stopped
    finally:
        restore()
