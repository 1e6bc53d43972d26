"""The file of a session: SQLite, opened, switched to its log, written in transactions and compacted.

Write-ahead log and ``synchronous=FULL``: what was written is on the disk, and what a kill or a power cut leaves behind
opens with it. Who reads has a connection of their own and sees what is on the disk; they never wait for who writes.
"""

from __future__ import annotations

import json
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

from tactogram.errors import DataError
from tactogram.signal.io.writable import check_writable
from tactogram.study.session.tables import TABLES, VERSION
from tactogram.study.study_file import Study

T = TypeVar("T")

FILE = "answers.sqlite"
TRIES = 40
"""How often opening a file is tried that another process is making."""
REST = "close all that has it open; what is left of it goes with that"
WAIT_S = 30.0
"""For another writer. A write takes some ms; only a vacuum takes longer."""


class SessionFile:
    """The file in which one study's session lies; safe for several threads and processes at once.

    Parameters
    ----------
    folder : Path
    study : Study, optional
        Needed for a folder that is new; else it must be the one that was begun.

    Raises
    ------
    DataError
        If the folder holds another study, or a file that is no session store.
    ParameterError
        If a study cannot be begun or continued there.
    """

    def __init__(self, folder: Path, study: Study | None = None) -> None:
        self.path = folder / FILE
        if study is None and not self.path.is_file():
            raise DataError(f"{folder}: no study was begun here; run one, or say which folder holds it")
        if study is not None:
            check_writable(folder, folder=True)
        folder.mkdir(parents=True, exist_ok=True)
        self._lock, self._looking = threading.RLock(), threading.Lock()
        try:
            self._connection = self._connected()
            self.study = self._begun(study)
            self._reader = self._connected()
            self._reader.execute("PRAGMA query_only=ON")
        except sqlite3.DatabaseError as error:
            raise DataError(f"{self.path}: no readable session store: {error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; what was stored stays."""
        with self._lock, self._looking:
            self._connection.close()
            self._reader.close()

    @property
    def ended(self) -> str | None:
        """When the experimenter ended the study, by the clock of then; None while it goes on."""
        with self._reading() as rows:
            return ended_at(rows)

    def end(self) -> None:
        """End the study: nobody joins, and who has not finished does not go on. What was answered stays."""
        with self._writing() as rows:
            rows.execute("UPDATE study SET ended = ? WHERE ended IS NULL", (now_utc(),))

    def go_on(self) -> None:
        """Let a study go on that was ended."""
        with self._writing() as rows:
            rows.execute("UPDATE study SET ended = NULL")

    def together(self, writes: Sequence[Callable[[], T]]) -> list[T | Exception]:
        """Do several writes in one transaction, which goes to the disk once, and return what each gave or raised.

        One that raises has stored nothing, and harms no other. Nothing of this may be told to anybody before it
        returns: until then nothing is on the disk.

        Parameters
        ----------
        writes : sequence of callable
            Each calls one of the methods that store something.

        Raises
        ------
        DataError
            If the file cannot be written to; nothing of any is stored then.
        """
        found: list[T | Exception] = []
        with self._writing():
            for write in writes:
                try:
                    with self._part():
                        found.append(write())
                except sqlite3.OperationalError:  # the file's, not one write's
                    raise
                except Exception as error:  # an error in the program, too, is of one alone
                    found.append(error)
        return found

    def compact(self) -> None:
        """Write the file anew without what was deleted, and empty its log.

        Raises
        ------
        DataError
            If another process reads it all the while; what was deleted is deleted, and may stand in the file or its log
            until all have closed it.
        """
        with self._lock, self._looking:
            try:
                self._connection.execute("VACUUM")
                busy = self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()[0]
            except sqlite3.OperationalError as error:
                raise DataError(f"{self.path}: deleted, but not written anew: {error}; {REST}") from error
            if busy:
                raise DataError(f"{self.path}: deleted, but its log could not be emptied; {REST}")

    def _connected(self) -> sqlite3.Connection:
        return sqlite3.connect(self.path, timeout=WAIT_S, isolation_level=None, check_same_thread=False)

    def _begun(self, study: Study | None) -> Study:
        connection = self._connection
        self._use_log()
        connection.execute("PRAGMA synchronous=FULL")
        connection.execute("PRAGMA secure_delete=ON")
        connection.execute("PRAGMA foreign_keys=ON")
        with self._writing() as rows:
            version = rows.execute("PRAGMA user_version").fetchone()[0]
            if version not in (0, VERSION):
                raise DataError(
                    f"{self.path}: is of version {version}, this program reads version {VERSION}; "
                    "open it with the program that made it"
                )
            if version == 0:
                if study is None:
                    raise DataError(f"{self.path}: holds no study")
                for table in TABLES:
                    rows.execute(table)
                rows.execute(
                    "INSERT INTO study (id, facts, begun) VALUES (1,?,?)", (study.as_json(), now_utc())
                )
                rows.execute(f"PRAGMA user_version = {VERSION}")
            [facts] = rows.execute("SELECT facts FROM study").fetchone()
        begun = Study.of(json.loads(facts), where=str(self.path))
        if study is not None and study.sha256 != begun.sha256:
            raise DataError(
                f"{self.path.parent}: was begun with another {begun.name} than this {study.name} (they differ in "
                f"{begun.differing(study)}); give another folder, or the file as it was"
            )
        return begun

    def _use_log(self) -> None:
        """Switch to the write-ahead log; another process may be doing the same to a new file."""
        for attempt in range(TRIES):
            try:
                self._connection.execute("PRAGMA journal_mode=WAL")
            except sqlite3.OperationalError:
                if attempt == TRIES - 1:
                    raise
                time.sleep(0.05)
            else:
                return

    @contextmanager
    def _reading(self) -> Iterator[sqlite3.Connection]:
        """Give a connection that sees the file as it was at one instant; it waits for nobody who writes."""
        with self._looking:
            self._reader.execute("BEGIN")
            try:
                yield self._reader
            finally:
                self._reader.execute("COMMIT")

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        """Give the connection in a transaction that no other writer is in; within `together`, in a part of its."""
        with self._lock:
            within = self._connection.in_transaction  # of this thread, which has the lock
            with self._part() if within else self._transaction():
                yield self._connection

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        connection = self._connection
        try:
            connection.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                # A full disk has rolled it back already.
                if connection.in_transaction:
                    connection.execute("ROLLBACK")
                raise
            connection.execute("COMMIT")
        except sqlite3.OperationalError as error:
            # A full disk, a file that went away, another writer that never ends.
            if connection.in_transaction:
                connection.execute("ROLLBACK")
            raise DataError(f"{self.path}: nothing was stored: {error}") from error

    @contextmanager
    def _part(self) -> Iterator[None]:
        """Undo what is written within, and nothing else of the transaction, where it raises."""
        connection = self._connection
        connection.execute("SAVEPOINT part")
        try:
            yield
        except BaseException:
            if connection.in_transaction:
                connection.execute("ROLLBACK TO part")
                connection.execute("RELEASE part")
            raise
        connection.execute("RELEASE part")


def ended_at(rows: sqlite3.Connection) -> str | None:
    """Return when the study was ended, None while it goes on."""
    [ended] = rows.execute("SELECT ended FROM study").fetchone()
    return None if ended is None else str(ended)


def now_utc() -> str:
    """Return the time as the store writes it; it orders nothing."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def add_device(rows: sqlite3.Connection, number: int, token: str, facts: Mapping[str, Any]) -> None:
    """Write down what a device says of itself, within a transaction; nothing where it says nothing."""
    if facts:
        rows.execute(
            "INSERT INTO device (participant, token, facts, at) VALUES (?,?,?,?)",
            (number, token, json.dumps(facts, ensure_ascii=False), now_utc()),
        )
