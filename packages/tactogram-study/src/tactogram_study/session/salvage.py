"""Salvage of damaged session files: the answers that can still be read."""

from __future__ import annotations

import shutil
import sqlite3
import tempfile
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from tactogram.errors import DataError, TactogramError
from tactogram_study.answers import Answers
from tactogram_study.session.file import FILE, UnreadableRowError, parse_answer, parse_object, session_file
from tactogram_study.study_file import Study


@dataclass(frozen=True)
class SalvagedSession:
    """Readable part of a session file; ``lost`` is the least number of answers that are not."""

    answers: Answers
    lost: int
    study: Study | None


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
