"""Salvage of damaged session files: the error that names one, and the answers that can still be read."""

from __future__ import annotations

import json
import re
import shutil
import sqlite3
import tempfile
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, TactogramError
from tactogram.study.answers import Answer, Answers
from tactogram.study.session.tables import FILE
from tactogram.study.study_file import Study

MOST_LOOKUPS = 1_000_000
"""Rows that are looked up one by one where the file cannot be read through."""
DAMAGE = (sqlite3.SQLITE_ERROR, sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
"""SQLite's codes of a file that lacks a table, is malformed, or is no database; a full disk has another."""


class DamagedSessionError(DataError):
    """A session file is damaged; the message says how many answers can still be read."""

    def __init__(self, folder: Path, reason: object) -> None:
        self.folder = folder
        try:
            count = len(salvage_session(folder).answers)
        except (TactogramError, OSError):
            count = 0
        self.readable = count
        answers = f"{count} answer{'' if count == 1 else 's'} can still be read"
        self.summary = (
            f"{folder}: {FILE} is damaged ({reason}); {answers if count else 'no answer can be read'}"
        )
        super().__init__(f"{self.summary}, and exported with salvage=True" if count else self.summary)


class UnreadableRowError(DataError):
    """A row of a session file does not hold what its table stores."""


@dataclass(frozen=True)
class SalvagedSession:
    """Readable part of a session file; ``lost`` answers are a minimum unless ``lost_is_exact``."""

    answers: Answers
    lost: int
    lost_is_exact: bool
    study: Study | None


def session_file(folder: Path) -> Path:
    """Return the file of a session; raise `DataError` if the folder holds none."""
    if not (folder / FILE).is_file():
        raise DataError(f"{folder}: no study was begun here; run one, or say which folder holds it")
    return folder / FILE


def is_damage(error: sqlite3.Error) -> bool:
    """Return whether an error of SQLite is due to the file's content, rather than to the operation."""
    code = getattr(error, "sqlite_errorcode", None)
    # Python itself reports text that is not UTF-8, without a code.
    return code & 0xFF in DAMAGE if code is not None else "decode to UTF-8" in str(error)


def parse_answer(text: str | bytes) -> Answer:
    """Return the answer of a row of JSON; raise `UnreadableRowError` if it holds none."""
    values = parse_object(text)
    try:
        return Answer(**values)
    except TypeError as error:
        raise UnreadableRowError(f"a row of answers is not readable: {error}") from error


def parse_object(text: str | bytes) -> dict[str, Any]:
    """Return the JSON object of a cell; raise `UnreadableRowError` if it holds none."""
    try:
        values = json.loads(text)
    except (ValueError, TypeError, RecursionError) as error:
        raise UnreadableRowError(f"a row is not readable: {error}") from error
    if not isinstance(values, dict):
        raise UnreadableRowError(f"a row must hold a JSON object, got {str(values)[:40]!r}")
    return values


def salvage_session(folder: Path) -> SalvagedSession:
    """Return every answer of a session file that can be read, whatever else is damaged; the file is not changed.

    Answers come by participant and in the order given. If SQLite cannot read the table at all, they are searched in the
    bytes of the file, and come in the order of their times.
    """
    path = session_file(folder)
    with tempfile.TemporaryDirectory(prefix="tactogram-salvage-") as temporary:
        copy = Path(temporary) / FILE
        for suffix in ("", "-wal"):
            with suppress(FileNotFoundError):
                shutil.copyfile(f"{path}{suffix}", f"{copy}{suffix}")
        content = b"".join(part.read_bytes() for part in sorted(copy.parent.glob(f"{FILE}*")))
        with closing(sqlite3.connect(copy, isolation_level=None)) as rows:
            rows.text_factory = bytes
            with suppress(sqlite3.Error):
                rows.execute("PRAGMA writable_schema=ON")  # else a file that was cut short is not read at all
            stored = sorted(_stored(rows, len(content)), key=lambda cells: cells[:3])
            answers = [answer for *_, text in stored for answer in _readable(text)]
            expected = [count for count in (_count(rows), _page_answers(rows)) if count is not None]
            study = _study(rows)
    answers = answers or _carved(content)
    lost = max(0, max([*expected, len(stored)]) - len(answers))
    return SalvagedSession(Answers(tuple(answers)), lost, bool(expected), study)


def _stored(rows: sqlite3.Connection, size: int) -> list[tuple[int, int, int, bytes]]:
    """Return participant, position, place and JSON of each row that SQLite can read, around damaged pages, too."""
    query = "SELECT rowid, participant, position, place, row FROM answers"
    found: dict[int, tuple[Any, ...]] = {}
    low, high = 0, min(MOST_LOOKUPS, size // 20)  # a row takes more than 20 bytes
    with suppress(sqlite3.Error):
        rows.execute(f"{query} LIMIT 0")
        with suppress(sqlite3.Error):
            for rowid, *cells in rows.execute(f"{query} ORDER BY rowid"):
                found[rowid] = tuple(cells)
        low = max((rowid for rowid in found if rowid < high), default=0)
        with suppress(sqlite3.Error):
            for rowid, *cells in rows.execute(f"{query} ORDER BY rowid DESC"):
                if rowid in found:
                    high = low
                    break
                found[rowid] = tuple(cells)
                high = min(rowid, high)
        for rowid in range(low + 1, high):
            with suppress(sqlite3.Error):
                for _, *cells in rows.execute(f"{query} WHERE rowid = ?", (rowid,)):
                    found[rowid] = tuple(cells)
    kinds = (int, int, int, bytes)
    return [cells for cells in found.values() if tuple(map(type, cells)) == kinds]


def _readable(text: bytes) -> list[Answer]:
    try:
        return [parse_answer(text)]
    except UnreadableRowError:
        return []


def _count(rows: sqlite3.Connection) -> int | None:
    """Return how many answers the table's index counts."""
    with suppress(sqlite3.Error):
        return int(rows.execute("SELECT count(*) FROM answers").fetchone()[0])
    return None


def _page_answers(rows: sqlite3.Connection) -> int | None:
    """Return how many answers the answered pages had: one for each question."""
    with suppress(sqlite3.Error, UnreadableRowError):
        return sum(len(parse_object(text)) for (text,) in rows.execute("SELECT responses FROM pages"))
    return None


def _study(rows: sqlite3.Connection) -> Study | None:
    with suppress(sqlite3.Error, TactogramError, TypeError):
        [facts] = rows.execute("SELECT facts FROM study").fetchone()
        return Study.of(parse_object(facts))
    return None


def _carved(content: bytes) -> list[Answer]:
    """Return the answers whose JSON lies in one piece among the bytes of a file that SQLite cannot read."""
    text, rows = (
        content.decode("latin-1"),
        dict[str, None](),
    )  # several copies of a row may remain in free space
    for start in re.finditer(re.escape('{"study": '), text):
        with suppress(ValueError, RecursionError):
            _, end = json.JSONDecoder().raw_decode(text, start.start())
            rows.setdefault(text[start.start() : end])
    answers = [answer for row in rows for answer in _readable(row.encode("latin-1"))]
    return sorted(answers, key=lambda answer: (answer.participant, answer.at))
