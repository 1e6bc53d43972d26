"""Session logs beside the answers: playback, device facts, the experimenter's notes."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from typing import Any

from tactogram.errors import ParameterError
from tactogram.study.session.device_facts import kept_facts
from tactogram.study.session.file import add_device, now_utc
from tactogram.study.session.participants import SessionPeople, active, find_participant
from tactogram.study.trials import Participant


class SessionLogs(SessionPeople):
    """Logs of a session beside the answers."""

    def played(self, code: str, token: str) -> dict[str, str]:
        """Return the hash of what was last played in each slot of a page."""
        with self._reading() as rows:
            return last_played(rows, find_participant(rows, code).participant, token)

    def played_log(self, code: str) -> list[dict[str, Any]]:
        """Return all that was played to a participant: ``token``, ``slot``, ``sha256``, ``level`` … ``at``."""
        names = ("token", "slot", "sha256", "level", "display", "gain_db", "at")
        with self._reading() as rows:
            found = rows.execute(
                f"SELECT {', '.join(names)} FROM played WHERE participant = ? ORDER BY id",
                (find_participant(rows, code).participant.number,),
            ).fetchall()
        return [dict(zip(names, row, strict=True)) for row in found]

    def note_device(self, code: str, device: Mapping[str, Any]) -> None:
        """Keep what a device says of itself as a participant begins or goes on with it."""
        with self._writing() as rows:
            add_device(rows, active(rows, code).number, "", kept_facts(device))

    def device_log(self, code: str) -> list[dict[str, Any]]:
        """Return what devices said: ``token`` ("" as the participant began or went on), ``facts``, ``at``."""
        with self._reading() as rows:
            found = rows.execute(
                "SELECT token, facts, at FROM device WHERE participant = ? ORDER BY id",
                (find_participant(rows, code).participant.number,),
            ).fetchall()
        return [{"token": token, "facts": json.loads(facts), "at": at} for token, facts, at in found]

    def device(self, code: str) -> dict[str, Any]:
        """Return the last word on each fact of a participant's device."""
        return {name: fact for one in self.device_log(code) for name, fact in one["facts"].items()}

    def note(self, text: str, *, code: str | None = None) -> None:
        """Write down what the experimenter saw, about one participant or the whole.

        Raises
        ------
        ParameterError
            If it is empty or longer than 4,000 characters, or nobody has the code.
        """
        if not 0 < len(text.strip()) <= 4000:
            raise ParameterError(f"a note must have 1 to 4000 characters, got {len(text.strip())}")
        with self._writing() as rows:
            number = None if code is None else find_participant(rows, code).participant.number
            rows.execute(
                "INSERT INTO notes (participant, text, at) VALUES (?,?,?)", (number, text.strip(), now_utc())
            )

    def notes(self) -> list[dict[str, Any]]:
        """Return all notes, first ones first: ``participant`` (None is the whole study), ``text``, ``at``."""
        with self._reading() as rows:
            found = rows.execute(
                "SELECT code, text, at FROM notes LEFT JOIN participants ON number = participant ORDER BY id"
            ).fetchall()
        return [{"participant": code, "text": text, "at": at} for code, text, at in found]


def last_played(rows: sqlite3.Connection, participant: Participant, token: str) -> dict[str, str]:
    """Return the hash of what was last played in each slot of a page."""
    found = rows.execute(
        "SELECT slot, sha256 FROM played WHERE participant = ? AND token = ? ORDER BY id",
        (participant.number, token),
    )
    return dict(found.fetchall())
