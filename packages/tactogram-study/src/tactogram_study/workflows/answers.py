"""Answers of a session, an exported or a foreign table: opened for analysis, and exported.

Exports are a tidy table with its companion files, a BIDS folder, or a ZIP file; of a damaged session what can still be
read.
"""

from __future__ import annotations

import io
import json
import shutil
import sqlite3
import tempfile
from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import DataError, ParameterError, Remedy, TactogramError
from tactogram.parameters import checked
from tactogram.signal.io import UndatedZip, write_text
from tactogram.text_files import read_json
from tactogram_study.answers import SUFFIXES, Answers, read_answers, write_answers
from tactogram_study.session.answer_import import TableMapping, import_answers
from tactogram_study.session.export import export_bids, write_companion_tables
from tactogram_study.session.file import FILE, UnreadableRowError, parse_answer, parse_object, session_file
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study


def open_answers(
    source: Path | str,
    *,
    columns: Mapping[str, str] | None = None,
    constants: Mapping[str, str] | None = None,
    encoding: str = "",
) -> Answers:
    """Return the answers of a session folder or a table; ``columns`` or ``constants`` make it a foreign table."""
    path = Path(source)
    if path.is_dir():
        with SessionStore(path) as store:
            return store.answers()
    if path.suffix.lower() not in SUFFIXES:
        raise ParameterError(f"{path}: answers are a session folder or {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise DataError(path, "no such file")
    if columns or constants:
        return import_answers(path, TableMapping(columns or {}, constants or {}, encoding=encoding))
    return read_answers(path)


def study_of(source: Path) -> Study | None:
    """Return the study of a session folder, or of the file that `export_study` writes with a table, if any."""
    if source.is_dir():
        with SessionStore(source) as store:
            return store.study
    file = source.with_suffix(STUDY_SUFFIX)
    if not file.is_file():
        return None
    return Study.of(read_json(file), where=str(file))


STUDY_SUFFIX = ".study.json"
"""Suffix of the file beside a table that holds its study."""


def export_zip(folder: Path | str, *, kind: Literal["tables", "bids"]) -> tuple[str, bytes]:
    """Return the name and the bytes of a ZIP file with the tables or the BIDS folder of `export_study`."""
    name = Path(folder).resolve().name
    with tempfile.TemporaryDirectory(prefix="tactogram-export-") as temporary:
        whole = Path(temporary) / f"{name}-{kind}"
        if kind == "bids":
            export_study(folder, bids=whole)
        else:
            whole.mkdir()
            export_study(folder, out=whole / "answers.csv")
        packed = io.BytesIO()
        with UndatedZip(packed) as file:
            for path in sorted(whole.rglob("*")):
                if path.is_file():
                    file.write(path, path.relative_to(whole.parent))
    return f"{name}-{kind}.zip", packed.getvalue()


@checked
def export_study(
    folder: Path | str,
    *,
    out: Path | str | None = None,
    bids: Path | str | None = None,
    salvage: bool = False,
) -> dict[str, Any]:
    """Write the answers of a session as a tidy table or a BIDS folder.

    Companion files of the table are the study (``.study.json``), the participants (``.participants.csv``) and the notes
    (``.notes.csv``).

    Parameters
    ----------
    folder : Path or str
        Folder of the session.
    out : Path or str, optional
        A tidy table: .csv, .tsv or .parquet.
    bids : Path or str, optional
        A BIDS folder, which must be new.
    salvage : bool
        Damaged session: write every answer that can still be read into the table, with the study beside it where that
        is readable.

    Returns
    -------
    dict
        Numbers of answers and participants, and the files; of a damaged session the least number of answers that are
        ``lost``.

    Raises
    ------
    DamagedSessionError
        If the session is damaged, without ``salvage``.
    """
    if out is None and bids is None:
        raise ParameterError("export needs a target", remedy=(Remedy("give", "out"), Remedy("", "bids")))
    if salvage:
        if out is None or bids is not None:
            remedy = Remedy("give", "out") if out is None else Remedy("omit", "bids")
            raise ParameterError("writes a table alone", parameter="salvage", remedy=remedy)
        return _salvage(Path(folder), Path(out))
    with SessionStore(Path(folder)) as store:
        answers = store.answers()
        facts = _facts(answers) | {
            "study": store.study.name,
            "withdrawn": store.withdrawn,
            "notes": len(store.notes()),
        }
        if out is not None:
            path = Path(out)
            write_answers(path, answers)
            participants, notes = write_companion_tables(path, store)
            facts |= {
                "table": str(path),
                "study_file": _write_study(path, store.study),
                "participants_table": str(participants),
                "notes_table": str(notes),
            }
        if bids is not None:
            facts["bids"] = str(export_bids(store, Path(bids)))
    return facts


def _salvage(folder: Path, table: Path) -> dict[str, Any]:
    salvaged = salvage_session(folder)
    write_answers(table, salvaged.answers)
    study_file = None if salvaged.study is None else _write_study(table, salvaged.study)
    return _facts(salvaged.answers) | {
        "study": salvaged.answers.rows[0].study,
        "lost": salvaged.lost,
        "table": str(table),
        "study_file": study_file,
    }


def _facts(answers: Answers) -> dict[str, Any]:
    return {
        "study": "",
        "answers": len(answers),
        "participants": answers.people,
        "simulated_participants": answers.where(simulated=True).people,
    }


def _write_study(table: Path, study: Study) -> str:
    path = table.with_suffix(STUDY_SUFFIX)
    write_text(path, json.dumps(json.loads(study.as_json()), ensure_ascii=False, indent=1) + "\n")
    return str(path)


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
            with suppress(sqlite3.Error, UnicodeDecodeError):
                rows.execute("PRAGMA writable_schema=ON")  # else a file that was cut short is not read at all
            stored: dict[int, bytes] = {}
            for order in ("ASC", "DESC"):
                with suppress(sqlite3.Error, UnicodeDecodeError):
                    stored |= rows.execute(f"SELECT rowid, row FROM answers ORDER BY rowid {order}")
            answers = []
            for _, text in sorted(stored.items()):
                with suppress(UnreadableRowError):
                    answers.append(parse_answer(text))
            expected, study = len(stored), None
            with suppress(sqlite3.Error, UnicodeDecodeError):
                expected = max(expected, *rows.execute("SELECT count(*) FROM answers").fetchone())
            with suppress(sqlite3.Error, UnicodeDecodeError, TactogramError, TypeError):
                [facts] = rows.execute("SELECT facts FROM study").fetchone()
                study = Study.of(parse_object(facts))
    if not answers:
        raise DataError(folder, "no answer can be read")
    return SalvagedSession(Answers(tuple(answers)), expected - len(answers), study)
