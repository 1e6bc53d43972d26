"""Tap on a source: live traces while a session or a classifier reads it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Self

from tactogram_capture.source import Block, Source

BlockListener = Callable[[Source, Block | None], None]
"""Called with the source and each block as it is read; None if none arrived in time."""


class TappedSource:
    """A source that also passes each block to a listener.

    The listener must be quick. Its exceptions end the reading, so that it can stop a session or a live classifier by
    ``KeyboardInterrupt``.
    """

    def __init__(self, source: Source, listener: BlockListener) -> None:
        self._source, self._listener = source, listener

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the source itself: axes, unit, rate, facts, full scale and others."""
        return getattr(self._source, name)

    def __enter__(self) -> Self:
        self._source.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._source.__exit__(*error)

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return the source's next block after passing it to the listener."""
        block = self._source.read(timeout_s)
        self._listener(self._source, block)
        return block
