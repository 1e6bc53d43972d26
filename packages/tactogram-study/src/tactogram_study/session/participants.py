"""Participants of a session, codes and numbers, never names, and the logs beside their answers."""

from __future__ import annotations

import json
import re
import secrets
import sqlite3
from collections.abc import Mapping
from typing import Any

from tactogram.errors import ParameterError
from tactogram_study.session.device_facts import valid_facts
from tactogram_study.session.file import SessionFile, add_device, ended_at, now_utc, parse_object
from tactogram_study.trials import Participant
from tactogram_study.wording import Language

CODE = re.compile(r"(?=.*[0-9])[A-Za-z0-9]{2,16}")
"""Letters and digits, as BIDS requires, with at least one digit, so that it is no name."""
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ"
DIGITS = "23456789"
PAIRS = 4
"""Letters with a digit each in a drawn code: 30 bits."""
ENDED = "the study was ended by the experimenter"
_SELECT = "SELECT code, number, language, simulated, session, status FROM participants"


class UnknownParticipantError(ParameterError):
    """No participant has the code, or the one who had it withdrew."""


class PageNotOpenError(ParameterError):
    """The answers belong to another page than the current one, or the experimenter ended the session."""


class SessionPeople(SessionFile):
    """The participants of a session, and the logs beside their answers; see `SessionFile` for its parameters."""

    def enrol(
        self,
        code: str | None = None,
        *,
        language: Language | None = None,
        simulated: bool = False,
        device: Mapping[str, Any] | None = None,
    ) -> Participant:
        """Return a new participant, with the lowest free number, and the code, or a random one.

        The number of a withdrawn participant is assigned again, so that the counterbalancing stays complete. The
        language is by default the study's first; ``device`` holds device facts. Raises `ParameterError` if the code is
        taken or may be a name, the study lacks the language, or simulated participants and people would share the
        session.
        """
        language = language or self.study.languages[0]
        self._check_language(language)
        if code is not None:
            checked_code(code)
        with self._writing() as rows:
            if ended_at(rows) is not None:
                raise PageNotOpenError(ENDED)
            self._check_kind(rows, simulated)
            taken = {row[0].casefold() for row in rows.execute("SELECT code FROM participants")}
            if code is not None and code.casefold() in taken:
                raise ParameterError(f"code {code} is taken; give another, or continue with it")
            while code is None or code.casefold() in taken:
                code = drawn_code()
            used = {row[0] for row in rows.execute("SELECT number FROM participants")}
            number = next(n for n in range(1, len(used) + 2) if n not in used)
            rows.execute(
                "INSERT INTO participants (number, code, language, simulated, session, status) VALUES (?,?,?,?,?,?)",
                (number, code, language, simulated, "1", "active"),
            )
            add_device(rows, number, "", valid_facts(device))
        return Participant(code, number, language, simulated)

    def participant(self, code: str) -> Participant:
        """Return the participant with a code, in any case; raise `UnknownParticipantError` if there is none."""
        with self._reading() as rows:
            return find_participant(rows, code)

    def participants(self) -> list[Participant]:
        """Return all participants by number."""
        with self._reading() as rows:
            return stored_participants(rows)

    def set_language(self, code: str, language: Language) -> None:
        """Change the language of a participant's pages; raise `ParameterError` if the study lacks it."""
        self._check_language(language)
        self._set(code, "language", language)

    def abort(self, code: str) -> None:
        """End a participant's session now; their answers are kept."""
        self._set(code, "status", "aborted")

    def reopen(self, code: str) -> None:
        """Let a participant continue whose session was aborted."""
        self._set(code, "status", "active")

    def withdraw(self, code: str) -> int:
        """Delete a participant with all their data, and return the number of answers deleted.

        The space is overwritten (``secure_delete``), the file rewritten and its log emptied. Earlier exports still
        hold the answers.
        """
        with self._writing() as rows:
            number = find_participant(rows, code).number
            query = "SELECT count(*) FROM answers WHERE participant = ?"
            count = rows.execute(query, (number,)).fetchone()[0]
            for table in ("answers", "pages", "played", "notes", "device"):
                rows.execute(f"DELETE FROM {table} WHERE participant = ?", (number,))
            rows.execute("DELETE FROM participants WHERE number = ?", (number,))
            rows.execute("UPDATE study SET withdrawn = withdrawn + 1")
        self.compact()
        return int(count)

    @property
    def withdrawn(self) -> int:
        """Number of participants who withdrew."""
        with self._reading() as rows:
            return int(rows.execute("SELECT withdrawn FROM study").fetchone()[0])

    def played_log(self, code: str) -> list[dict[str, Any]]:
        """Return all playback to a participant: ``token``, ``slot``, ``sha256``, ``level`` … ``at``, ``facts``.

        The facts are those of a stream: the level as driven, latency, motion; {} of everything else.
        """
        columns = ("token", "slot", "sha256", "level", "display", "gain_db", "at", "facts")
        return self._log(code, "played", columns)

    def complete_played(self, row: int, facts: Mapping[str, Any]) -> None:
        """Add the facts of a stream that has ended to its row of the log, unless the participant withdrew."""
        with self._writing() as rows:
            rows.execute("UPDATE played SET facts = ? WHERE id = ?", (json.dumps(facts), row))

    def log_device(self, code: str, device: Mapping[str, Any]) -> None:
        """Store device facts as a participant begins or continues."""
        with self._writing() as rows:
            participant = find_participant(rows, code)
            check_active(participant)
            add_device(rows, participant.number, "", valid_facts(device))

    def device_log(self, code: str) -> list[dict[str, Any]]:
        """Return the device facts: ``token`` ("" as the participant began or continued), ``facts``, ``at``."""
        return self._log(code, "device", ("token", "facts", "at"))

    def device(self, code: str) -> dict[str, Any]:
        """Return the latest value of each fact of a participant's device."""
        return {name: fact for entry in self.device_log(code) for name, fact in entry["facts"].items()}

    def note(self, text: str, *, code: str | None = None) -> None:
        """Store a note about one participant or the study; raise `ParameterError` if empty or too long."""
        if not 0 < len(text.strip()) <= 4000:
            raise ParameterError(f"a note must have 1 to 4000 characters, got {len(text.strip())}")
        with self._writing() as rows:
            number = None if code is None else find_participant(rows, code).number
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
                (find_participant(rows, code).number,),
            ).fetchall()
        log = [dict(zip(columns, entry, strict=True)) for entry in entries]
        with self._damage_reported():
            return [entry | {"facts": parse_object(entry["facts"])} for entry in log]

    def _set(self, code: str, column: str, value: str) -> None:
        with self._writing() as rows:
            number = find_participant(rows, code).number
            rows.execute(f"UPDATE participants SET {column} = ? WHERE number = ?", (value, number))

    def _check_language(self, language: str) -> None:
        if language not in self.study.languages:
            known = ", ".join(self.study.languages)
            raise ParameterError.must("language", f"be one of {known}", language[:20])

    def _check_kind(self, rows: sqlite3.Connection, simulated: bool) -> None:
        if rows.execute("SELECT 1 FROM participants WHERE simulated != ?", (simulated,)).fetchone():
            kinds = ["people", "simulated participants"]
            present, other = kinds if simulated else kinds[::-1]
            raise ParameterError(
                f"{present} take this study here; {other} need a session folder of their own"
            )


def find_participant(rows: sqlite3.Connection, code: str) -> Participant:
    """Return the participant with a code, in any case; raise `UnknownParticipantError` if there is none."""
    row = rows.execute(f"{_SELECT} WHERE code = ? COLLATE NOCASE", (code,)).fetchone()
    if row is None:
        raise UnknownParticipantError(f"no participant has the code {code[:40]!r}")
    return _participant(row)


def stored_participants(rows: sqlite3.Connection) -> list[Participant]:
    """Return all participants by number."""
    return [_participant(row) for row in rows.execute(f"{_SELECT} ORDER BY number").fetchall()]


def _participant(row: tuple[Any, ...]) -> Participant:
    code, number, language, simulated, session, status = row
    return Participant(code, number, language, bool(simulated), session, status == "active")


def check_active(participant: Participant) -> None:
    """Raise `PageNotOpenError` if the experimenter ended the participant's session."""
    if not participant.active:
        raise PageNotOpenError(f"the session of {participant.code} was ended by the experimenter")


def checked_code(code: str) -> str:
    """Return a code; raise `ParameterError` if it may be a name, or is too short or long."""
    if not CODE.fullmatch(code):
        raise ParameterError.must(
            "code", "be 2 to 16 letters and digits with a digit among them, never a name", code[:40]
        )
    return code


def drawn_code() -> str:
    """Return a code that is easy to read and type and hard to guess: letters and digits in turn."""
    return "".join(secrets.choice(LETTERS) + secrets.choice(DIGITS) for _ in range(PAIRS))


def last_played(rows: sqlite3.Connection, participant: Participant, token: str) -> dict[str, str]:
    """Return the hash of what was last played in each slot of a page."""
    hashes = rows.execute(
        "SELECT slot, sha256 FROM played WHERE participant = ? AND token = ? ORDER BY id",
        (participant.number, token),
    )
    return dict(hashes.fetchall())
