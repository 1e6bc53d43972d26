"""Answers for analysis, of a session, an exported or a foreign table, and their study."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from tactogram.errors import DataError, ParameterError
from tactogram_study.answers import SUFFIXES, Answers, read_answers
from tactogram_study.session.answer_import import TableMapping, import_answers
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study
from tactogram_study.workflows.export import STUDY_SUFFIX


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
        raise DataError(f"{path}: no such file")
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
    try:
        facts = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"{file}: not a readable study: {error}; export the answers again") from error
    return Study.of(facts, where=str(file))
