"""Sessions of studies: start, progress, notes, abort, end and withdrawal."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tactogram.errors import DataError
from tactogram.signal.io import write_text
from tactogram.text_files import read_json
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import Study, shipped_studies
from tactogram_study.trials import Page
from tactogram_study.workflows.studies import check_study, study_folder

if TYPE_CHECKING:
    from tactogram_study.workflows.stimuli import SlotPlayback, StudyStimuli

ORIGIN = "origin.json"
"""File in a session folder with the path of its study."""


def begin_session(study: Path | str, out: Path | str, *, changes: Mapping[str, Any] | None = None) -> Path:
    """Start a study in a session folder, or continue it, and return the folder.

    The path of the study's file is written next to the answers (``origin.json``): stimuli are relative to it.

    Raises `TactogramError` if the study is wrong, a stimulus's file is missing, or the folder holds another study.
    """
    check_study(study, changes=changes)
    folder = Path(out)
    with SessionStore(folder, Study.load(study, changes=changes)):
        pass
    keep_origin(folder, study)
    return folder


def origin_folder(session: Path | str) -> Path:
    """Return the folder of a session's study; the session's own folder if it is not recorded.

    Raises `DataError` if the record cannot be read.
    """
    path = Path(session) / ORIGIN
    if not path.is_file():
        return Path(session)
    try:
        return study_folder(read_json(path)["study"])
    except (DataError, KeyError, TypeError) as error:
        reason = str(error) if isinstance(error, DataError) else f"{path}: lacks the study"
        raise DataError(f"{reason}; run the study again with its file") from None


def keep_origin(folder: Path, study: Path | str) -> None:
    """Record the path of the study's file in a session folder."""
    shipped = str(study) in shipped_studies()
    origin = {"study": str(study) if shipped else str(Path(study).resolve()), "shipped": shipped}
    write_text(folder / ORIGIN, json.dumps(origin, ensure_ascii=False) + "\n")


def begin_trials(store: SessionStore, code: str) -> None:
    """Answer the consent and the questions before the trials for a participant, each with a first possible answer."""
    while (page := store.participant_state(code).page) is not None and page.kind in ("consent", "questions"):
        answers = {question.key: question.question.example for question in page.questions}
        store.submit(code, page.token, answers)


def session_progress(folder: Path | str) -> dict[str, Any]:
    """Return the progress of each participant, their counts by status, the notes, and when the session was ended."""
    with SessionStore(Path(folder)) as store:
        everybody = store.progress()
        return {
            "folder": str(folder),
            "study": store.study.name,
            "participants": [known | {"device": store.device(known["participant"])} for known in everybody],
            "statuses": dict(Counter(known["status"] for known in everybody)),
            "notes": store.notes(),
            "ended": store.ended,
            "withdrawn": store.withdrawn,
            "answers": store.count,
        }


def write_note(folder: Path | str, text: str, *, code: str | None = None) -> dict[str, Any]:
    """Add an experimenter's note, about one participant or the whole study."""
    with SessionStore(Path(folder)) as store:
        store.note(text, code=code)
        return {"folder": str(folder), "notes": len(store.notes())}


def abort_participant(folder: Path | str, code: str, *, undo: bool = False) -> dict[str, Any]:
    """End a participant's session, or let them continue; the answers stay."""
    with SessionStore(Path(folder)) as store:
        (store.reopen if undo else store.abort)(code)
        return {"folder": str(folder), "participant": code, "state": store.state(code)}


def end_session(folder: Path | str, *, undo: bool = False) -> dict[str, Any]:
    """End a study, so that nobody joins or continues, or reopen it."""
    with SessionStore(Path(folder)) as store:
        (store.reopen_study if undo else store.end)()
        return {"folder": str(folder), "ended": store.ended}


def withdraw(folder: Path | str, code: str) -> dict[str, Any]:
    """Delete a participant and all their data in a session folder."""
    with SessionStore(Path(folder)) as store:
        deleted = store.withdraw(code)
        left = len(store.participants())
    return {"folder": str(folder), "answers_deleted": deleted, "participants_left": left}


def log_played(store: SessionStore, stimuli: StudyStimuli, code: str, page: Page, slot: str) -> SlotPlayback:
    """Render the stimulus in a slot of a participant's page, log it, and return it."""
    played = stimuli.played(page.slot(slot))
    store.log_played(
        code,
        page.token,
        slot,
        sha256=played.sha256,
        level=played.level,
        display=played.display,
        gain_db=played.gain_db,
    )
    return played
