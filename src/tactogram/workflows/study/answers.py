"""Answers read for analysis: of a session, of an exported table, of another's table; and the study they are of."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from tactogram.errors import DataError, ParameterError
from tactogram.study.answers import SUFFIXES, Answers, read_answers
from tactogram.study.session.answer_import import TableMapping, import_answers
from tactogram.study.session.store import SessionStore
from tactogram.study.study_file import Study
from tactogram.workflows.study.export import STUDY_SUFFIX


def open_answers(
    source: Path | str,
    *,
    columns: Mapping[str, str] | None = None,
    constants: Mapping[str, str] | None = None,
    encoding: str = "utf-8-sig",
) -> Answers:
    """Return the answers of a session folder, of a table, or of another's table by a mapping of columns.

    Parameters
    ----------
    source : Path
    columns, constants : mapping, optional
        See `tactogram.study.session.answer_import.TableMapping`; any of them makes it another's table.
    encoding : str
    """
    path = Path(source)
    if path.is_dir():
        with SessionStore(path) as store:
            return store.answers()
    if path.suffix.lower() not in SUFFIXES:
        raise ParameterError(f"{path}: answers are a session folder or {', '.join(SUFFIXES)}")
    if not path.is_file():
        raise DataError(f"{path}: no such file")
    if columns or constants:
        return import_answers(path, TableMapping(columns or {}, constants or {}, encoding=encoding))
    return read_answers(path)


def study_of(source: Path) -> Study | None:
    """Return the study that answers are of: of a session folder, or of the file that stands beside a table.

    `tactogram.workflows.study.export.export_study` writes that file. None where there is none.
    """
    if source.is_dir():
        with SessionStore(source) as store:
            return store.study
    beside = source.with_suffix(STUDY_SUFFIX)
    if not beside.is_file():
        return None
    try:
        facts = json.loads(beside.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"{beside}: not a readable study: {error}; export the answers again") from error
    return Study.of(facts, where=str(beside))
