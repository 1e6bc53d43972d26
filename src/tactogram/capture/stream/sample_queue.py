"""Bounded queue for sources whose driver delivers samples in a callback, with losses in place."""

from __future__ import annotations

from collections import deque
from threading import Condition
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from tactogram.capture.source import Block, SourceLost


class BlockQueue:
    """Blocks from a driver's thread to the reader's. What does not fit is lost, in its place, and counted.

    Parameters
    ----------
    axes : int
    most : int
        Samples that may wait.
    """

    def __init__(self, axes: int, most: int) -> None:
        self.received = self.lost = 0
        self._axes, self._most = axes, most
        self._waiting: deque[tuple[NDArray[np.float32], float]] = deque()
        self._held = self._next = self._pending = 0
        self._end: str | None = None
        self._changed = Condition()

    def put(self, samples: NDArray[np.float32], *, lost_before: int = 0) -> None:
        """Take samples, float32, (axis, n), behind a number that the driver lost. Copies."""
        with self._changed:
            self._pending += lost_before
            if self._held + samples.shape[1] > self._most:
                self._pending += samples.shape[1]
                return
            if self._pending:
                gap = np.full((self._axes, self._pending), np.nan, np.float32)
                self._waiting.append((gap, monotonic()))
                self.lost += self._pending
                self._pending = 0
            if samples.shape[1]:
                self._waiting.append((np.array(samples, np.float32), monotonic()))
                self._held += samples.shape[1]
                self.received += samples.shape[1]
            self._changed.notify()

    def close(self, why: str) -> None:
        """Say that no more will come."""
        with self._changed:
            self._end = why
            self._changed.notify()

    def get(self, timeout_s: float) -> Block | None:
        """Return all that waits as one block; None if nothing came in time.

        Raises
        ------
        SourceLost
            If nothing waits and nothing more will come.
        """
        with self._changed:
            if not self._waiting and self._end is None:
                self._changed.wait(timeout_s)
            if not self._waiting:
                if self._end is not None:
                    raise SourceLost(self._end)
                return None
            pieces = list(self._waiting)
            self._waiting.clear()
            self._held = 0
        samples = np.concatenate([piece for piece, _ in pieces], axis=1)
        first, self._next = self._next, self._next + samples.shape[1]
        return Block(samples, first, pieces[-1][1])
