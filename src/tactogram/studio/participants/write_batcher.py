"""Write batcher: answers that wait for the disk share one transaction."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, TypeVar

import anyio
import anyio.to_thread

from tactogram.study.session.file import SessionFile

T = TypeVar("T")


class WriteBatcher:
    """Writes to one session's file, from one event loop. Writes that arrive during a transaction share the next."""

    def __init__(self, file: SessionFile) -> None:
        self._file = file
        self._waiting: list[tuple[Callable[[], Any], asyncio.Future[Any]]] = []
        self._storing: asyncio.Task[None] | None = None
        # A thread of its own: answers are stored even while all others are busy.
        self._thread = anyio.CapacityLimiter(1)

    async def store(self, write: Callable[[], T]) -> T:
        """Call ``write``, which stores something, in a thread; return or raise its outcome once that is on the disk."""
        loop = asyncio.get_running_loop()
        outcome: asyncio.Future[T] = loop.create_future()
        self._waiting.append((write, outcome))
        if self._storing is None:
            self._storing = loop.create_task(self._store_waiting())
        return await outcome

    async def _store_waiting(self) -> None:
        try:
            while self._waiting:
                batch, self._waiting = self._waiting, []
                writes = [write for write, _ in batch]
                try:
                    results = await anyio.to_thread.run_sync(
                        self._file.write_together, writes, limiter=self._thread
                    )
                except Exception as error:
                    # Fails all of them: the disk is full, the session was closed, there is no thread.
                    results = [error] * len(batch)
                for (_, outcome), result in zip(batch, results, strict=True):
                    if outcome.done():  # the sender disconnected; the answer is stored all the same
                        continue
                    if isinstance(result, Exception):
                        outcome.set_exception(result)
                    else:
                        outcome.set_result(result)
        finally:
            self._storing = None
