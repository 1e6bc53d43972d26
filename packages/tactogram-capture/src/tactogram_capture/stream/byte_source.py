"""Source that parses the bytes of a stream."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from time import monotonic
from typing import Any, Self

from tactogram_capture.source import Block, SourceEnded
from tactogram_capture.stream.byte_stream import ByteStream
from tactogram_capture.stream.raw_log import LoggedStream


class ByteSource(ABC):
    """Base of sources that parse bytes; see `tactogram_capture.source.Source`.

    ``name`` is the address, ``log`` a new file for all bytes (`RawLog`) of the kind ``"twelite"`` or ``"serial"``.
    """

    def __init__(
        self, stream: ByteStream, *, name: str, kind: str, log: Path | str | None, simulated: bool
    ) -> None:
        self.name, self.simulated = name, simulated
        if log is not None:
            stream = LoggedStream(stream, log, kind=kind, address=name, simulated=simulated)
        self._stream = stream
        self._end: str | None = None

    def __enter__(self) -> Self:
        self._stream.__enter__()
        return self

    def __exit__(self, *error: Any) -> None:
        self._stream.__exit__(*error)

    def read(self, timeout_s: float = 0.1) -> Block | None:
        """Return new samples; None if none arrived within ``timeout_s``."""
        if self._end is not None:
            raise SourceEnded(self._end)
        until = monotonic() + timeout_s
        while True:
            try:
                received = self._stream.read(max(0.0, until - monotonic()))
            except SourceEnded as end:
                self._end = str(end)
                block = self._finish()
                if block is None:
                    raise
                return block
            if received is None:
                return None
            block = self._parse(*received)
            if block is not None or monotonic() >= until:
                return block

    @abstractmethod
    def _parse(self, data: bytes, arrival_s: float) -> Block | None:
        """Return the samples that ``data`` completes."""

    @abstractmethod
    def _finish(self) -> Block | None:
        """Return the remaining samples."""
