"""Bounded queue for sources whose driver delivers samples in a callback, with losses in place."""

from __future__ import annotations

from collections import deque
from threading import Condition
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from tactogram_capture.source import Block, SourceLost


class BlockQueue:
    """Blocks from a driver's thread to the reader's.

    At most ``most`` samples wait; samples that do not fit are lost, marked and counted.
    """

    def __init__(self, axes: int, most: int) -> None:
        self.received = self.lost = 0
        self._axes, self._most = axes, most
        self._waiting: deque[tuple[NDArray[np.float32], float]] = deque()
        self._waiting_samples = self._next = self._gap = 0
        self._end: str | None = None
        self._changed = Condition()

    def put(self, samples: NDArray[np.float32], *, lost_before: int = 0) -> None:
        """Append a copy of samples, float32, shape (axis, n), after ``lost_before`` that the driver lost."""
        with self._changed:
            self._gap += lost_before
            if self._waiting_samples + samples.shape[1] > self._most:
                self._gap += samples.shape[1]
                return
            if self._gap:
                gap = np.full((self._axes, self._gap), np.nan, np.float32)
                self._waiting.append((gap, monotonic()))
                self.lost += self._gap
                self._gap = 0
            if samples.shape[1]:
                self._waiting.append((np.array(samples, np.float32), monotonic()))
                self._waiting_samples += samples.shape[1]
                self.received += samples.shape[1]
            self._changed.notify()

    def close(self, reason: str) -> None:
        """End the queue after the waiting samples."""
        with self._changed:
            self._end = reason
            self._changed.notify()

    def get(self, timeout_s: float) -> Block | None:
        """Return all waiting samples as one block; None if none arrived in time.

        Raises `SourceLost` if the queue is empty and closed.
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
            self._waiting_samples = 0
        samples = np.concatenate([piece for piece, _ in pieces], axis=1)
        first, self._next = self._next, self._next + samples.shape[1]
        return Block(samples, first, pieces[-1][1])
