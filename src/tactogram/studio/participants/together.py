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
    """Writes to one session's file. Those that come while others are being stored wait, and share the next transaction.

    For one event loop.

    Parameters
    ----------
    file : SessionFile
    """

    def __init__(self, file: SessionFile) -> None:
        self._file = file
        self._waiting: list[tuple[Callable[[], Any], asyncio.Future[Any]]] = []
        self._storing: asyncio.Task[None] | None = None
        # One thread of their own: whatever else is waited for, answers are stored.
        self._thread = anyio.CapacityLimiter(1)

    async def done(self, write: Callable[[], T]) -> T:
        """Do a write in a thread, and return what it gives, or raise what it raises, once that is on the disk.

        Parameters
        ----------
        write : callable
            Calls one of the store's methods that store something.
        """
        loop = asyncio.get_running_loop()
        told: asyncio.Future[T] = loop.create_future()
        self._waiting.append((write, told))
        if self._storing is None:
            self._storing = loop.create_task(self._store())
        return await told

    async def _store(self) -> None:
        try:
            while self._waiting:
                turn, self._waiting = self._waiting, []
                writes = [write for write, _ in turn]
                try:
                    found = await anyio.to_thread.run_sync(self._file.together, writes, limiter=self._thread)
                except Exception as error:
                    # Of all: the disk is full, the session was closed, there is no thread.
                    found = [error] * len(turn)
                for (_, told), one in zip(turn, found, strict=True):
                    if told.done():  # who sent it has gone; it is stored all the same
                        continue
                    if isinstance(one, Exception):
                        told.set_exception(one)
                    else:
                        told.set_result(one)
        finally:
            self._storing = None
