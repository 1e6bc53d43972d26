"""Salvage of damaged session files: the error that names one, and the answers that can still be read."""

from __future__ import annotations

import json
import shlex
import shutil
import sqlite3
import tempfile
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, TactogramError
from tactogram_study.answers import Answer, Answers
from tactogram_study.session.tables import FILE
from tactogram_study.study_file import Study

DAMAGE = (sqlite3.SQLITE_ERROR, sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
"""SQLite's codes of a file that lacks a table, is malformed, or is no database; a full disk has another."""


class DamagedSessionError(DataError):
    """A session file is damaged; the message has the command that exports what can still be read."""

    def __init__(self, folder: Path, reason: object) -> None:
        command = f"tactogram study export {shlex.quote(str(folder))} --salvage --out F.csv"
        super().__init__(
            f"{folder}: {FILE} is damaged ({reason}); export the answers that can still be read: {command}"
        )


class UnreadableRowError(DataError):
    """A row of a session file does not hold what its table stores."""


@dataclass(frozen=True)
class SalvagedSession:
    """Readable part of a session file; ``lost`` is the least number of answers that are not."""

    answers: Answers
    lost: int
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
    """Return the answers before and after the damage in a session file, which is not changed, as they arrived.

    Raises `DataError` if SQLite can read none.
    """
    path = session_file(folder)
    with tempfile.TemporaryDirectory(prefix="tactogram-salvage-") as temporary:
        copy = Path(temporary) / FILE
        for suffix in ("", "-wal"):
            with suppress(FileNotFoundError):
                shutil.copyfile(f"{path}{suffix}", f"{copy}{suffix}")
        with closing(sqlite3.connect(copy, isolation_level=None)) as rows:
            rows.text_factory = bytes
            with suppress(sqlite3.Error):
                rows.execute("PRAGMA writable_schema=ON")  # else a file that was cut short is not read at all
            stored: dict[int, bytes] = {}
            for order in ("ASC", "DESC"):
                with suppress(sqlite3.Error):
                    stored |= rows.execute(f"SELECT rowid, row FROM answers ORDER BY rowid {order}")
            answers = []
            for _, text in sorted(stored.items()):
                with suppress(UnreadableRowError):
                    answers.append(parse_answer(text))
            expected, study = len(stored), None
            with suppress(sqlite3.Error):
                expected = max(expected, *rows.execute("SELECT count(*) FROM answers").fetchone())
            with suppress(sqlite3.Error, TactogramError, TypeError):
                [facts] = rows.execute("SELECT facts FROM study").fetchone()
                study = Study.of(parse_object(facts))
    if not answers:
        raise DataError(f"{folder}: no answer can be read")
    return SalvagedSession(Answers(tuple(answers)), expected - len(answers), study)
