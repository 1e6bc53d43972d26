"""What an experimenter does with a session besides running it: look, note, abort, end."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tactogram.study.session_store import SessionStore


def session_progress(folder: Path | str) -> dict[str, Any]:
    """Return where each participant of a session stands, the notes, and whether the study was ended."""
    with SessionStore(Path(folder)) as store:
        return {
            "folder": str(folder),
            "study": store.study.name,
            "participants": [
                known | {"device": store.device(known["participant"])} for known in store.progress()
            ],
            "notes": store.notes(),
            "ended": store.ended,
            "withdrawn": store.withdrawn,
            "answers": store.count,
        }


def write_note(folder: Path | str, text: str, *, code: str | None = None) -> dict[str, Any]:
    """Write down what the experimenter saw, about one participant or the whole study."""
    with SessionStore(Path(folder)) as store:
        store.note(text, code=code)
        return {"folder": str(folder), "notes": len(store.notes())}


def abort_participant(folder: Path | str, code: str, *, undo: bool = False) -> dict[str, Any]:
    """End a participant's session now, or let them go on again; what was answered stays."""
    with SessionStore(Path(folder)) as store:
        (store.reopen if undo else store.abort)(code)
        return {"folder": str(folder), "participant": code, "state": store.state(code)}


def end_session(folder: Path | str, *, undo: bool = False) -> dict[str, Any]:
    """End a study, so that nobody joins or goes on, or let it go on again."""
    with SessionStore(Path(folder)) as store:
        (store.go_on if undo else store.end)()
        return {"folder": str(folder), "ended": store.ended}
