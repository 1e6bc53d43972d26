"""Byte streams, a serial port or a log of one, and sources that parse them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from time import monotonic
from types import TracebackType
from typing import Any, Protocol, Self

from tactogram.errors import one_line
from tactogram.extras import device_errors, imported
from tactogram_capture.source import Block, SourceEnded, SourceLost
from tactogram_capture.stream.raw_log import RawLog

BAUD = 115200
"""Default of TWE-Lite receivers and most boards."""

_MOST_BYTES = 65536
_WAIT_S = 0.02


class ByteStream(Protocol):
    """Stream of bytes; a context manager that opens on entry."""

    name: str

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    def read(self, timeout_s: float) -> tuple[bytes, float] | None:
        """Return bytes and their arrival (s, clock of ``time.monotonic``, or a log's); None if none arrived in time.

        Raises `SourceEnded` or `SourceLost` if there will be no more.
        """
        ...


class SerialPort:
    """A serial port (``/dev/ttyUSB0``, ``COM3``), or a URL of pyserial (``socket://host:port``, ``loop://``)."""

    def __init__(self, port: str, baud: int = BAUD) -> None:
        self.name, self.baud = port, baud
        self._port: Any = None

    def __enter__(self) -> Self:
        """Open it.

        Raises `MissingExtraError` without pyserial, `DeviceError` if the port is missing, not permitted or in use.
        """
        serial = imported("serial", extra="devices", what="sensors on a serial port")
        with device_errors(self.name):
            # Two programs that read one port would each get half of the bytes.
            self._port = serial.serial_for_url(self.name, baudrate=self.baud, timeout=_WAIT_S, exclusive=True)
        return self

    def __exit__(self, *_: object) -> None:
        port, self._port = self._port, None
        if port is not None:
            try:
                port.close()
            except (OSError, ValueError, AttributeError):
                # An unplugged port may not close cleanly, and nothing is left to close.
                return

    def read(self, timeout_s: float) -> tuple[bytes, float] | None:
        """Return bytes and their arrival; None if none arrived in time; `SourceLost` if the plug was pulled."""
        if self._port is None:
            raise SourceLost(f"{self.name}: is not open")
        until = monotonic() + timeout_s
        while True:
            try:
                data: bytes = self._port.read(1)
                if data:
                    waiting = min(self._port.in_waiting, _MOST_BYTES)
                    data += self._port.read(waiting) if waiting else b""
            except (OSError, ValueError, TypeError, AttributeError) as error:
                raise SourceLost(f"{self.name}: disappeared while it was read ({one_line(error)})") from error
            if data:
                return data, monotonic()
            if monotonic() >= until:
                return None


class Replay:
    """Recorded pieces of bytes with their arrival times."""

    def __init__(self, name: str, pieces: Iterator[tuple[bytes, float]]) -> None:
        self.name, self._pieces = name, pieces

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if hasattr(self._pieces, "close"):
            self._pieces.close()

    def read(self, timeout_s: float) -> tuple[bytes, float] | None:
        """Return the next piece at once; raises SourceEnded at the end."""
        try:
            return next(self._pieces)
        except StopIteration:
            raise SourceEnded(f"{self.name}: ended") from None


class ByteSource(ABC):
    """Base of sources that parse bytes; see `tactogram_capture.source.Source`.

    ``name`` is the address, ``log`` a new file for all bytes (`RawLog`) of the kind ``"twelite"`` or ``"serial"``.
    """

    def __init__(
        self, stream: ByteStream, *, name: str, kind: str, log: Path | str | None, simulated: bool
    ) -> None:
        self.name, self.simulated = name, simulated
        self._stream, self._log_path = stream, log
        self._log_facts: dict[str, Any] = {"kind": kind, "address": name, "simulated": simulated}
        self._log: RawLog | None = None
        self._opened = ExitStack()
        self._end: str | None = None

    def __enter__(self) -> Self:
        """Open the log, then the stream: without a log nothing is recorded."""
        with ExitStack() as stack:
            if self._log_path is not None:
                self._log = stack.enter_context(RawLog(self._log_path, **self._log_facts))
            stack.enter_context(self._stream)
            self._opened = stack.pop_all()
        return self

    def __exit__(self, *error: Any) -> None:
        self._opened.__exit__(*error)

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
            if self._log is not None:
                self._log.write(*received)
            block = self._parse(*received)
            if block is not None or monotonic() >= until:
                return block

    @abstractmethod
    def _parse(self, data: bytes, arrival_s: float) -> Block | None:
        """Return the samples that ``data`` completes."""

    @abstractmethod
    def _finish(self) -> Block | None:
        """Return the remaining samples."""
