"""A source that somebody else looks at while it is read: live traces beside a session or a classifier."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from tactogram.capture.source import Block, Source

BlockListener = Callable[[Source, Block | None], None]
"""Called with the source and each block as it is read, None where nothing came in time."""


class TappedSource:
    """A source as it is, of which each block is handed on, too.

    Parameters
    ----------
    source : Source
        Not entered yet.
    hears : callable
        See `BlockListener`. What it raises ends the reading, so that it can stop a session or a live classifier by
        ``KeyboardInterrupt``; it should take no time.
    """

    def __init__(self, source: Source, hears: BlockListener) -> None:
        self._source, self._hears = source, hears

    def __getattr__(self, name: str) -> Any:
        """Return what the source itself has: axes, unit, rate, facts, full scale, and what only some have."""
        return getattr(self._source, name)

    def __enter__(self) -> Self:
        """Open the source."""
        self._source.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self._source.__exit__(kind, error, trace)

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return what the source returns, once it was handed on."""
        block = self._source.read(timeout_s)
        self._hears(self._source, block)
        return block
