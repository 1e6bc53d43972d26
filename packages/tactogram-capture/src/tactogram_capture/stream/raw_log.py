r"""Logs of the bytes of a port: our own, which lose nothing, and those of other programs.

Our own has a line of facts, then a line for every piece that was read: its arrival (s), a tab, and the bytes escaped as
in a Python literal, so that hex frames stay readable and binary ones survive:

    # tactogram raw log {"kind": "twelite", "address": "twelite:/dev/ttyUSB0", "simulated": false}
    10.034512	:8000000063001781013C850035DF057702F2000000FF96FFF0BB\r\n

It reproduces exactly the samples seen live, because the same bytes go through the same parser.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from io import TextIOWrapper
from pathlib import Path
from typing import Any, Self

from tactogram.errors import DataError
from tactogram.text_files import check_regular, decode_text, parse_json

HEAD = "# tactogram raw log "

_MOST_HEAD_BYTES = 4096
_CHUNK = 65536
_LONGEST_LINE = 1 << 20
_STAMP = re.compile(
    r"\s*[\[(]?(?:(?P<date>\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d{1,9})?(?:Z|[+-]\d\d:?\d\d)?)"
    r"|(?P<clock>\d\d:\d\d:\d\d(?:[.,]\d{1,9})?)|(?P<seconds>\d{1,12}(?:\.\d{1,9})?))[\])]?"
    # A frame begins with one of these, and nothing else in a receiver's line does; numbers of a board follow a clock.
    r"(?:(?:[\s>|-]+|,\s*(?=[:;]))(?=[:;,])|(?(seconds)(?!))(?:\s*->\s*|\s+|[,;]\s*)(?=[^\s,;]))"
)
_STAMP_STARTS = frozenset(bytes([c]) for c in b"0123456789[( \t")
"""First characters of time stamps; no frame begins with one."""


class RawLog:
    """Writer of a log of the kind ``"twelite"`` or ``"serial"``; written pieces survive a crash of this program.

    ``path`` must not exist yet; `DataError` if it cannot be created.
    """

    def __init__(self, path: Path | str, *, kind: str, address: str, simulated: bool = False) -> None:
        self.path = Path(path)
        try:
            self._file: TextIOWrapper = self.path.open("x", encoding="ascii", newline="\n")
        except FileExistsError:
            raise DataError(f"{path} must not exist yet; choose another file for the log") from None
        except (OSError, ValueError) as error:
            raise _log_error(path, "cannot be written", error) from None
        head = json.dumps({"kind": kind, "address": address, "simulated": simulated})
        self._file.write(f"{HEAD}{head}\n")
        self._file.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def write(self, data: bytes, arrival_s: float) -> None:
        """Write one piece; `DataError` if the disk is full or gone."""
        try:
            self._file.write(f"{arrival_s!r}\t{escaped(data)}\n")
            self._file.flush()
        except OSError as error:
            raise _log_error(self.path, "cannot be written", error) from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def escaped(data: bytes) -> str:
    """Return ``data`` as one line of ASCII."""
    return data.decode("latin-1").encode("unicode_escape").decode("ascii")


def unescaped(text: str) -> bytes:
    """Return the bytes that `escaped` wrote."""
    return text.encode("ascii").decode("unicode_escape").encode("latin-1")


def log_facts(path: Path) -> dict[str, Any] | None:
    """Return the facts in the first line of our own log; None for another program's.

    Raises `DataError` if it is not readable, or its first line is damaged.
    """
    with _opened(path) as file:
        first = file.readline(_MOST_HEAD_BYTES)
    if not first.startswith(HEAD.encode()):
        return None
    where = f"{path}, line 1"
    facts = parse_json(decode_text(first, where).removeprefix(HEAD), where)
    if not isinstance(facts, dict):
        raise DataError(f'{where}: must hold facts in JSON, like {{"kind": "twelite"}}, got {facts!r}')
    return facts


def log_pieces(path: Path) -> Iterator[tuple[bytes, float]]:
    """Yield the bytes of a log with their arrival, NaN where it is unknown.

    In other programs' logs, a time in front of a line is parsed (s, ``12:34:56.789``, or a date and time);
    all else is passed on unchanged. Raises `DataError` if a log is not readable, or our own is damaged; only its last
    line may be incomplete, as after a crash.
    """
    if log_facts(path) is not None:
        return _own_pieces(path)
    return _foreign_pieces(path)


def _own_pieces(path: Path) -> Iterator[tuple[bytes, float]]:
    with _opened(path) as file:
        file.readline()
        for number, line in enumerate(file, 2):
            stamp, tab, text = line.decode("latin-1").partition("\t")
            if not line.endswith(b"\n"):
                return  # incomplete: its end was never written
            try:
                piece = unescaped(text[:-1]), float(stamp)
            except ValueError:
                tab = ""
            if not tab:
                raise DataError(f"{path}, line {number}: must be a time, a tab and bytes, got {line[:40]!r}")
            yield piece


def _foreign_pieces(path: Path) -> Iterator[tuple[bytes, float]]:
    with _opened(path) as file:
        start = file.read(2)
        if start in (b"\xff\xfe", b"\xfe\xff"):  # UTF-16, as one shell writes text
            text = decode_text(start + file.read(), path, encoding="utf-16")
            yield from _stamped(iter(text.encode("latin-1", "replace").splitlines(keepends=True)))
            return
        file.seek(0)
        yield from _stamped(iter(lambda: file.readline(_LONGEST_LINE), b""))


def _stamped(lines: Iterator[bytes]) -> Iterator[tuple[bytes, float]]:
    """Yield lines without the times in front of them, and the times; runs of untimed lines as one piece."""
    untimed = bytearray()
    day, last = 0.0, float("-inf")
    for line in lines:
        match = _STAMP.match(line.decode("latin-1")) if line[:1] in _STAMP_STARTS else None
        if match is None:
            untimed += line
            if len(untimed) >= _CHUNK:
                yield bytes(untimed), float("nan")
                untimed.clear()
            continue
        if untimed:
            yield bytes(untimed), float("nan")
            untimed.clear()
        time = _seconds(match)
        if match["clock"] is not None:
            if time + day < last - 43200:
                day += 86400
            time += day
            last = time
        yield line[match.end() :], time
    if untimed:
        yield bytes(untimed), float("nan")


def _seconds(stamp: re.Match[str]) -> float:
    if stamp["seconds"] is not None:
        return float(stamp["seconds"])
    if stamp["clock"] is not None:
        hours, minutes, seconds = stamp["clock"].replace(",", ".").split(":")
        return 3600 * int(hours) + 60 * int(minutes) + float(seconds)
    try:
        time = datetime.fromisoformat(stamp["date"].replace(",", "."))
    except ValueError:
        return float("nan")
    return (time if time.tzinfo else time.replace(tzinfo=UTC)).timestamp()


def _opened(path: Path) -> Any:
    try:
        check_regular(path)
        return path.open("rb")
    except (OSError, ValueError) as error:
        raise _log_error(path, "cannot be read", error) from None


def _log_error(path: Path | str, problem: str, error: Exception) -> DataError:
    return DataError(path, f"the log {problem} ({getattr(error, 'strerror', None) or error})")
