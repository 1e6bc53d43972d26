"""Session file: its tables in SQLite, with a write-ahead log, transactions, compaction, and the errors of damaged ones.

With the log and ``synchronous=FULL`` whatever was stored survives a kill or a power cut. Readers have a connection of
their own, see what is on the disk, and never wait for writers.
"""

from __future__ import annotations

import json
import shlex
import sqlite3
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from tactogram.errors import DataError
from tactogram.signal.io import check_writable
from tactogram_study.answers import Answer
from tactogram_study.study_file import Study

FILE = "answers.sqlite"
VERSION = 4
"""The file's ``user_version``."""
TABLES = (
    "CREATE TABLE study (id INTEGER PRIMARY KEY CHECK (id = 1), facts TEXT NOT NULL, begun TEXT NOT NULL, "
    "withdrawn INTEGER NOT NULL DEFAULT 0, ended TEXT)",
    "CREATE TABLE participants (number INTEGER PRIMARY KEY, code TEXT NOT NULL UNIQUE COLLATE NOCASE, "
    "language TEXT NOT NULL, simulated INTEGER NOT NULL, session TEXT NOT NULL, status TEXT NOT NULL "
    "CHECK (status IN ('active', 'aborted')))",
    # Answered pages. The file enforces that a page is stored once, not the program.
    "CREATE TABLE pages (participant INTEGER NOT NULL REFERENCES participants, position INTEGER NOT NULL, "
    "token TEXT NOT NULL, responses TEXT NOT NULL, facts TEXT NOT NULL, "
    "PRIMARY KEY (participant, position), UNIQUE (participant, token))",
    # Rows as they were when answered: another version of the program cannot change them.
    "CREATE TABLE answers (participant INTEGER NOT NULL, position INTEGER NOT NULL, place INTEGER NOT NULL, "
    "row TEXT NOT NULL, PRIMARY KEY (participant, position, place), "
    "FOREIGN KEY (participant, position) REFERENCES pages (participant, position))",
    "CREATE TABLE played (id INTEGER PRIMARY KEY AUTOINCREMENT, participant INTEGER NOT NULL REFERENCES participants, "
    "token TEXT NOT NULL, slot TEXT NOT NULL, sha256 TEXT NOT NULL, level TEXT NOT NULL, display TEXT NOT NULL, "
    "gain_db REAL NOT NULL, at TEXT NOT NULL, facts TEXT NOT NULL DEFAULT '{}')",
    "CREATE INDEX played_by_page ON played (participant, token)",
    "CREATE TABLE notes (id INTEGER PRIMARY KEY AUTOINCREMENT, participant INTEGER REFERENCES participants, "
    "text TEXT NOT NULL, at TEXT NOT NULL)",
    # Device facts: with an answer, or with token "" when a participant began or continued.
    "CREATE TABLE device (id INTEGER PRIMARY KEY AUTOINCREMENT, participant INTEGER NOT NULL REFERENCES participants, "
    "token TEXT NOT NULL, facts TEXT NOT NULL, at TEXT NOT NULL)",
    "CREATE INDEX device_by_page ON device (participant, token)",
)
DAMAGE = (sqlite3.SQLITE_ERROR, sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
"""SQLite's codes of a file that lacks a table, is malformed, or is no database; a full disk has another."""
TRIES = 40
"""Attempts to open a file that another process is creating."""
REST = "close all programs that have it open; what is left of it goes with that"
WAIT_S = 30.0
"""Timeout for another writer. A write takes some ms; only a vacuum takes longer."""


class DamagedSessionError(DataError):
    """A session file is damaged; the message has the command that exports what can still be read."""

    def __init__(self, folder: Path, reason: object) -> None:
        command = f"tactogram study export {shlex.quote(str(folder))} --salvage --out F.csv"
        super().__init__(
            f"{folder}: {FILE} is damaged ({reason}); export the answers that can still be read: {command}"
        )


class UnreadableRowError(DataError):
    """A row of a session file does not hold what its table stores."""


class SessionFile:
    """File of one study session; safe for several threads and processes at once.

    ``study`` is required for a new folder; otherwise it must be the study that was begun there. Raises `DataError` if
    the folder holds another study, `DamagedSessionError` for a damaged file.
    """

    def __init__(self, folder: Path, study: Study | None = None) -> None:
        self.path = folder / FILE
        if study is None:
            session_file(folder)
        else:
            check_writable(folder, folder=True)
        folder.mkdir(parents=True, exist_ok=True)
        self._lock, self._reader_lock = threading.RLock(), threading.Lock()
        try:
            with self._damage_reported():
                self._connection = self._connect()
                self.study = self._begin(study)
                self._reader = self._connect()
                self._reader.execute("PRAGMA query_only=ON")
        except sqlite3.DatabaseError as error:
            raise DataError(self.path, f"cannot be opened: {error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        with self._lock, self._reader_lock:
            self._connection.close()
            self._reader.close()

    @property
    def ended(self) -> str | None:
        """Time at which the experimenter ended the study; None while it continues."""
        with self._reading() as rows:
            return ended_at(rows)

    def end(self) -> None:
        """End the study: nobody can join, and unfinished participants cannot continue. Answers are kept."""
        with self._writing() as rows:
            rows.execute("UPDATE study SET ended = ? WHERE ended IS NULL", (now_utc(),))

    def reopen_study(self) -> None:
        """Continue a study that was ended."""
        with self._writing() as rows:
            rows.execute("UPDATE study SET ended = NULL")

    def compact(self) -> None:
        """Rewrite the file without deleted rows, and empty its log.

        Raises `DataError` if another process keeps reading it: deleted rows may then remain in the file or its log
        until all programs have closed it.
        """
        with self._lock, self._reader_lock, self._damage_reported():
            try:
                self._connection.execute("VACUUM")
                busy = self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]
            except sqlite3.OperationalError as error:
                raise DataError(self.path, f"deleted, but not rewritten: {error}; {REST}") from error
            if busy:
                raise DataError(self.path, f"deleted, but its log could not be emptied; {REST}")

    def _connect(self) -> sqlite3.Connection:
        return sqlite3.connect(self.path, timeout=WAIT_S, isolation_level=None, check_same_thread=False)

    def _begin(self, study: Study | None) -> Study:
        connection = self._connection
        self._use_log()
        connection.execute("PRAGMA synchronous=FULL")
        connection.execute("PRAGMA secure_delete=ON")
        connection.execute("PRAGMA foreign_keys=ON")
        with self._writing() as rows:
            version = rows.execute("PRAGMA user_version").fetchone()[0]
            if version not in (0, VERSION):
                raise DataError(
                    self.path,
                    f"is of version {version}, this program reads version {VERSION}; "
                    "open it with the program that made it",
                )
            if version == 0:
                if study is None:
                    raise DataError(self.path, "holds no study")
                for table in TABLES:
                    rows.execute(table)
                rows.execute(
                    "INSERT INTO study (id, facts, begun) VALUES (1,?,?)", (study.as_json(), now_utc())
                )
                rows.execute(f"PRAGMA user_version = {VERSION}")
            row = rows.execute("SELECT facts FROM study").fetchone()
            if row is None:
                raise UnreadableRowError("the study's row is missing")
        begun = Study.of(parse_object(row[0]), where=str(self.path))
        if study is not None and study.sha256 != begun.sha256:
            raise DataError(
                self.path.parent,
                f"was begun with another {begun.name} than this {study.name} (they differ in "
                f"{begun.first_difference(study)}); give another folder, or the file as it was",
            )
        return begun

    def _use_log(self) -> None:
        """Switch to the write-ahead log; another process may be doing the same to a new file."""
        for attempt in range(TRIES):
            try:
                self._connection.execute("PRAGMA journal_mode=WAL")
            except sqlite3.OperationalError as error:
                if attempt == TRIES - 1 or is_damage(error):
                    raise
                time.sleep(0.05)
            else:
                return

    @contextmanager
    def _damage_reported(self) -> Iterator[None]:
        """Turn the errors of a damaged file into one that names the session."""
        try:
            yield
        except (UnreadableRowError, UnicodeDecodeError) as error:  # SQLite's messages quote the file
            raise DamagedSessionError(self.path.parent, error) from error
        except sqlite3.Error as error:
            if not is_damage(error):
                raise
            raise DamagedSessionError(self.path.parent, error) from error

    @contextmanager
    def _reading(self) -> Iterator[sqlite3.Connection]:
        """Give a connection that sees the file as it was at one instant, without waiting for writers."""
        with self._damage_reported(), self._reader_lock:
            self._reader.execute("BEGIN")
            try:
                yield self._reader
            finally:
                if self._reader.in_transaction:
                    self._reader.execute("COMMIT")

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        """Give the connection in a transaction."""
        connection = self._connection
        with self._lock:
            try:
                with self._damage_reported():
                    connection.execute("BEGIN IMMEDIATE")
                    yield connection
                    connection.execute("COMMIT")
            except BaseException as error:
                # A full disk has rolled it back already.
                if connection.in_transaction:
                    connection.execute("ROLLBACK")
                if isinstance(
                    error, sqlite3.OperationalError
                ):  # full disk, removed file, another writer that never ends
                    raise DataError(self.path, f"nothing was stored: {error}") from error
                raise


def ended_at(rows: sqlite3.Connection) -> str | None:
    """Return the time at which the study was ended, None while it continues."""
    row = rows.execute("SELECT ended FROM study").fetchone()
    if row is None:
        raise UnreadableRowError("the study's row is missing")
    return None if row[0] is None else str(row[0])


def now_utc() -> str:
    """Return the time as the file stores it; no order follows from it."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def add_device(rows: sqlite3.Connection, number: int, token: str, facts: Mapping[str, Any]) -> None:
    """Store device facts within a transaction, unless there are none."""
    if facts:
        rows.execute(
            "INSERT INTO device (participant, token, facts, at) VALUES (?,?,?,?)",
            (number, token, json.dumps(facts, ensure_ascii=False), now_utc()),
        )


def session_file(folder: Path) -> Path:
    """Return the file of a session; raise `DataError` if the folder holds none."""
    if not (folder / FILE).is_file():
        raise DataError(folder, "no study was begun here; run one, or say which folder holds it")
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
        raise UnreadableRowError("a row of answers lacks or misspells a column") from error


def parse_object(text: str | bytes) -> dict[str, Any]:
    """Return the JSON object of a cell; raise `UnreadableRowError` if it holds none."""
    try:
        values = json.loads(text)
    except (ValueError, TypeError, RecursionError) as error:
        raise UnreadableRowError(f"a row is not readable: {error}") from error
    if not isinstance(values, dict):
        raise UnreadableRowError(f"a row must hold a JSON object, got {str(values)[:40]!r}")
    return values
