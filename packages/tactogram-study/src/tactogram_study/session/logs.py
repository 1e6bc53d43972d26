"""Session logs beside the answers: playback, device facts, the experimenter's notes."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from typing import Any

from tactogram.errors import ParameterError
from tactogram_study.session.device_facts import valid_facts
from tactogram_study.session.file import add_device, now_utc
from tactogram_study.session.participants import SessionPeople, find_participant
from tactogram_study.session.salvage import parse_object
from tactogram_study.trials import Participant


class SessionLogs(SessionPeople):
    """Logs of a session beside the answers."""

    def played_log(self, code: str) -> list[dict[str, Any]]:
        """Return all playback to a participant: ``token``, ``slot``, ``sha256``, ``level`` … ``at``, ``facts``.

        The facts are those of a stream: the level as driven, latency, motion; {} of everything else.
        """
        columns = ("token", "slot", "sha256", "level", "display", "gain_db", "at", "facts")
        log = self._log(code, "played", columns)
        with self._damage_reported():
            return [entry | {"facts": parse_object(entry["facts"])} for entry in log]

    def complete_played(self, row: int, facts: Mapping[str, Any]) -> None:
        """Add the facts of a stream that has ended to its row of the log, unless the participant withdrew."""
        with self._writing() as rows:
            rows.execute("UPDATE played SET facts = ? WHERE id = ?", (json.dumps(facts), row))

    def log_device(self, code: str, device: Mapping[str, Any]) -> None:
        """Store device facts as a participant begins or continues."""
        with self._writing() as rows:
            record = find_participant(rows, code)
            record.check_active()
            add_device(rows, record.participant.number, "", valid_facts(device))

    def device_log(self, code: str) -> list[dict[str, Any]]:
        """Return the device facts: ``token`` ("" as the participant began or continued), ``facts``, ``at``."""
        log = self._log(code, "device", ("token", "facts", "at"))
        with self._damage_reported():
            return [entry | {"facts": parse_object(entry["facts"])} for entry in log]

    def device(self, code: str) -> dict[str, Any]:
        """Return the latest value of each fact of a participant's device."""
        return {name: fact for entry in self.device_log(code) for name, fact in entry["facts"].items()}

    def note(self, text: str, *, code: str | None = None) -> None:
        """Store a note about one participant or the study; raise `ParameterError` if empty or too long."""
        if not 0 < len(text.strip()) <= 4000:
            raise ParameterError(f"a note must have 1 to 4000 characters, got {len(text.strip())}")
        with self._writing() as rows:
            number = None if code is None else find_participant(rows, code).participant.number
            rows.execute(
                "INSERT INTO notes (participant, text, at) VALUES (?,?,?)", (number, text.strip(), now_utc())
            )

    def notes(self) -> list[dict[str, Any]]:
        """Return all notes, oldest first: ``participant`` (None is the whole study), ``text``, ``at``."""
        with self._reading() as rows:
            notes = rows.execute(
                "SELECT code, text, at FROM notes LEFT JOIN participants ON number = participant ORDER BY id"
            ).fetchall()
        return [{"participant": code, "text": text, "at": at} for code, text, at in notes]

    def _log(self, code: str, table: str, columns: tuple[str, ...]) -> list[dict[str, Any]]:
        with self._reading() as rows:
            entries = rows.execute(
                f"SELECT {', '.join(columns)} FROM {table} WHERE participant = ? ORDER BY id",
                (find_participant(rows, code).participant.number,),
            ).fetchall()
        return [dict(zip(columns, entry, strict=True)) for entry in entries]


def last_played(rows: sqlite3.Connection, participant: Participant, token: str) -> dict[str, str]:
    """Return the hash of what was last played in each slot of a page."""
    hashes = rows.execute(
        "SELECT slot, sha256 FROM played WHERE participant = ? AND token = ? ORDER BY id",
        (participant.number, token),
    )
    return dict(hashes.fetchall())
