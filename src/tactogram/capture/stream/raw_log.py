r"""Logs of the bytes of a port: our own, which lose nothing, and those that other programs wrote.

Our own has a line of facts, then a line for every piece that was read: when it came (s), a tab, and the bytes as
Python would write them between quotes, so that hex frames stay readable and a binary one survives:

    # tactogram raw log {"kind": "twelite", "address": "twelite:/dev/ttyUSB0", "simulated": false}
    10.034512	:8000000063001781013C850035DF057702F2000000FF96FFF0BB\r\n

Read back, it gives the very samples that were seen live, because the same bytes go through the same parser.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from io import TextIOWrapper
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from tactogram.capture.stream.byte_stream import ByteStream
from tactogram.errors import DataError

HEAD = "# tactogram raw log "

_CHUNK = 65536
_LONGEST = 1 << 20
_STAMP = re.compile(
    r"\s*[\[(]?(?:(?P<date>\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d{1,9})?(?:Z|[+-]\d\d:?\d\d)?)"
    r"|(?P<clock>\d\d:\d\d:\d\d(?:[.,]\d{1,9})?)|(?P<seconds>\d{1,12}(?:\.\d{1,9})?))[\])]?"
    # A frame begins with one of these, and nothing else of a receiver's line does.
    r"(?:[\s>|-]+|,\s*(?=[:;]))(?=[:;,])"
)


class RawLog:
    """Writes what comes from a port, piece by piece; what was written survives the end of this program.

    Parameters
    ----------
    path : Path
        Must not exist yet.
    kind : str
        ``"twelite"`` or ``"serial"``.
    address : str
        What was read.
    simulated : bool

    Raises
    ------
    DataError
        If it cannot be created.
    """

    def __init__(self, path: Path | str, *, kind: str, address: str, simulated: bool = False) -> None:
        self.path = Path(path)
        try:
            self._file: TextIOWrapper = self.path.open("x", encoding="ascii", newline="\n")
        except FileExistsError:
            raise DataError(f"{path} must not exist yet; choose another file for the log") from None
        except OSError as error:
            raise DataError(f"{path}: the log cannot be written ({error.strerror})") from None
        head = json.dumps({"kind": kind, "address": address, "simulated": simulated})
        self._file.write(f"{HEAD}{head}\n")
        self._file.flush()

    def __enter__(self) -> Self:
        """Return itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close it."""
        self.close()

    def write(self, data: bytes, arrival_s: float) -> None:
        """Write one piece.

        Raises
        ------
        DataError
            If the disk is full or gone.
        """
        try:
            self._file.write(f"{arrival_s!r}\t{escaped(data)}\n")
            self._file.flush()
        except OSError as error:
            raise DataError(f"{self.path}: the log cannot be written ({error.strerror})") from error

    def close(self) -> None:
        """Close it."""
        self._file.close()


class LoggedStream:
    """A `ByteStream` of which all that comes is kept in a new log.

    Parameters
    ----------
    stream : ByteStream
    path : Path
    kind, address, simulated
        As of `RawLog`.
    """

    def __init__(
        self, stream: ByteStream, path: Path | str, *, kind: str, address: str, simulated: bool = False
    ) -> None:
        self.name = stream.name
        self._stream, self._path = stream, path
        self._kind, self._address, self._simulated = kind, address, simulated
        self._log: RawLog | None = None

    def __enter__(self) -> Self:
        """Open both, the log first: what cannot be kept is not begun."""
        self._log = RawLog(self._path, kind=self._kind, address=self._address, simulated=self._simulated)
        try:
            self._stream.__enter__()
        except BaseException:
            self._close_log()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close both."""
        self._stream.__exit__(kind, error, trace)
        self._close_log()

    def read(self, timeout_s: float) -> tuple[bytes, float] | None:
        """Return what came and when, once it is in the log."""
        got = self._stream.read(timeout_s)
        if got is not None and self._log is not None:
            self._log.write(*got)
        return got

    def _close_log(self) -> None:
        if self._log is not None:
            self._log.close()
            self._log = None


def escaped(data: bytes) -> str:
    """Return ``data`` as one line of ASCII."""
    return data.decode("latin-1").encode("unicode_escape").decode("ascii")


def unescaped(text: str) -> bytes:
    """Return the bytes that `escaped` wrote."""
    return text.encode("ascii").decode("unicode_escape").encode("latin-1")


def log_facts(path: Path) -> dict[str, Any] | None:
    """Return the facts in the first line of our own log; None for another program's.

    Raises
    ------
    DataError
        If it cannot be read.
    """
    with _opened(path) as file:
        first = file.readline(4096).decode("latin-1")
    if not first.startswith(HEAD):
        return None
    try:
        facts = json.loads(first.removeprefix(HEAD))
    except ValueError:
        raise DataError(f"{path}, line 1: is no head of a raw log, got {first.strip()!r}") from None
    if not isinstance(facts, dict):
        raise DataError(f"{path}, line 1: is no head of a raw log, got {first.strip()!r}")
    return facts


def log_pieces(path: Path) -> Iterator[tuple[bytes, float]]:
    """Yield the bytes of a log and when they came, NaN where it does not say.

    Of other programs' logs a time in front of a line is understood (s, ``12:34:56.789``, or a date and time), any
    other content is passed on as it is.

    Raises
    ------
    DataError
        If it cannot be read, or our own is damaged; the last line of one may be cut short, as by a kill.
    """
    if log_facts(path) is not None:
        return _own(path)
    return _foreign(path)


def _own(path: Path) -> Iterator[tuple[bytes, float]]:
    with _opened(path) as file:
        file.readline()
        for number, line in enumerate(file, 2):
            stamp, tab, text = line.decode("latin-1").partition("\t")
            if not line.endswith(b"\n"):
                # Cut short: its end was never written.
                return
            try:
                piece = unescaped(text[:-1]), float(stamp)
            except ValueError:
                tab = ""
            if tab:
                yield piece
            else:
                raise DataError(f"{path}, line {number}: must be a time, a tab and bytes, got {line[:40]!r}")


def _foreign(path: Path) -> Iterator[tuple[bytes, float]]:
    with _opened(path) as file:
        start = file.read(2)
    if start in (b"\xff\xfe", b"\xfe\xff"):
        yield from _stamped(iter(_recoded(path).splitlines(keepends=True)))
        return
    with _opened(path) as file:
        yield from _stamped(iter(lambda: file.readline(_LONGEST), b""))


def _stamped(lines: Iterator[bytes]) -> Iterator[tuple[bytes, float]]:
    """Yield lines without the times in front of them, and those; runs of lines without any as one piece."""
    untimed = bytearray()
    day, last = 0.0, float("-inf")
    for line in lines:
        # Only a digit or a bracket can begin a time, and neither begins a frame.
        found = _STAMP.match(line.decode("latin-1")) if line[:1] in _BEGINS else None
        if found is None:
            untimed += line
            if len(untimed) >= _CHUNK:
                yield bytes(untimed), float("nan")
                untimed.clear()
            continue
        if untimed:
            yield bytes(untimed), float("nan")
            untimed.clear()
        time = _seconds(found)
        if found["clock"] is not None:
            if time + day < last - 43200:
                day += 86400
            time += day
            last = time
        yield line[found.end() :], time
    if untimed:
        yield bytes(untimed), float("nan")


_BEGINS = frozenset(bytes([c]) for c in b"0123456789[( \t")


def _seconds(found: re.Match[str]) -> float:
    if found["seconds"] is not None:
        return float(found["seconds"])
    if found["clock"] is not None:
        hours, minutes, seconds = found["clock"].replace(",", ".").split(":")
        return 3600 * int(hours) + 60 * int(minutes) + float(seconds)
    try:
        time = datetime.fromisoformat(found["date"].replace(",", "."))
    except ValueError:
        return float("nan")
    return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()


def _recoded(path: Path) -> bytes:
    """Return a UTF-16 text, as one shell writes it, as bytes of ASCII."""
    try:
        return path.read_bytes().decode("utf-16").encode("latin-1", "replace")
    except UnicodeDecodeError:
        raise DataError(f"{path}: begins like UTF-16 text and is none") from None


def _opened(path: Path) -> Any:
    try:
        return path.open("rb")
    except OSError as error:
        raise DataError(f"{path}: cannot be read ({error.strerror})") from None
