"""Participants of a session: codes and numbers, never names; enrolled, aborted, withdrawn."""

from __future__ import annotations

import re
import secrets
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tactogram.errors import ParameterError
from tactogram.study.session.device_facts import kept_facts
from tactogram.study.session.file import SessionFile, add_device, ended_at
from tactogram.study.trials import Participant
from tactogram.study.wording import Language

CODE = re.compile(r"(?=.*[0-9])[A-Za-z0-9]{2,16}")
"""Of a participant: letters and digits, so that BIDS takes it, and a digit at least, so that it is no name."""
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ"
DIGITS = "23456789"
ENDED = "the study was ended by the experimenter"


_KNOWN = "SELECT code, number, language, simulated, session, status FROM participants"


class UnknownParticipantError(ParameterError):
    """Nobody has a code: it never was one, or they withdrew."""


class PageNotOpenError(ParameterError):
    """The answers belong to another page than the current one, or the experimenter ended the session."""


@dataclass(frozen=True)
class ParticipantRecord:
    """A participant as the file has them.

    Parameters
    ----------
    participant : Participant
    active : bool
        False where the experimenter ended their session.
    """

    participant: Participant
    active: bool

    def check_active(self) -> None:
        """Refuse one whose session was ended.

        Raises
        ------
        NotNowError
        """
        if not self.active:
            raise PageNotOpenError(f"the session of {self.participant.code} was ended by the experimenter")


class SessionPeople(SessionFile):
    """The participants of a session; see `SessionFile` for its parameters."""

    def enrol(
        self,
        code: str | None = None,
        *,
        language: Language | None = None,
        simulated: bool = False,
        session: str = "1",
        device: Mapping[str, Any] | None = None,
    ) -> Participant:
        """Return a new participant, with the lowest number that is free.

        The number of who withdrew is given again, so that the counterbalancing stays whole.

        Parameters
        ----------
        code : str, optional
            By default one is drawn.
        language : {"ja", "en"}, optional
            By default the study's first.
        simulated : bool
        session : str
        device : mapping, optional
            What the device says of itself; see `tactogram.study.session.device_facts`.

        Raises
        ------
        ParameterError
            If the code is taken or may be a name, the study lacks the language, or one who is simulated would stand
            among people, or the other way round.
        """
        language = language or self.study.languages[0]
        self._check_language(language)
        if code is not None:
            checked_code(code)
        if not re.fullmatch(r"[A-Za-z0-9]{1,16}", session):
            raise ParameterError(f"session must be 1 to 16 letters and digits, got {session[:40]!r}")
        with self._writing() as rows:
            if ended_at(rows) is not None:
                raise PageNotOpenError(ENDED)
            self._check_kind(rows, simulated)
            taken = {row[0].casefold() for row in rows.execute("SELECT code FROM participants")}
            if code is not None and code.casefold() in taken:
                raise ParameterError(f"code {code} is taken; give another, or go on with it")
            while code is None or code.casefold() in taken:
                code = drawn_code()
            used = {row[0] for row in rows.execute("SELECT number FROM participants")}
            number = next(n for n in range(1, len(used) + 2) if n not in used)
            rows.execute(
                "INSERT INTO participants (number, code, language, simulated, session, status) VALUES (?,?,?,?,?,?)",
                (number, code, language, simulated, session, "active"),
            )
            add_device(rows, number, "", kept_facts(device))
        return Participant(code, number, language, simulated, session)

    def participant(self, code: str) -> Participant:
        """Return who has a code, whatever the case of its letters.

        Raises
        ------
        NobodyError
            If nobody has.
        """
        with self._reading() as rows:
            return find_participant(rows, code).participant

    def participants(self) -> list[Participant]:
        """Return all participants by number."""
        with self._reading() as rows:
            return [one.participant for one in everybody(rows)]

    def set_language(self, code: str, language: Language) -> None:
        """Change the language of a participant's pages.

        Raises
        ------
        ParameterError
            If the study lacks the language, or nobody has the code.
        """
        self._check_language(language)
        with self._writing() as rows:
            number = find_participant(rows, code).participant.number
            rows.execute("UPDATE participants SET language = ? WHERE number = ?", (language, number))

    def abort(self, code: str) -> None:
        """End a participant's session now; what was answered stays."""
        self._set_status(code, "aborted")

    def reopen(self, code: str) -> None:
        """Let a participant go on whose session was aborted."""
        self._set_status(code, "active")

    def withdraw(self, code: str) -> int:
        """Delete a participant and everything that is kept of them, and return how many answers that were.

        The space is overwritten (``secure_delete``), the file is written anew and its log emptied. What was exported
        before is out of reach: it is to be exported again.
        """
        with self._writing() as rows:
            participant = find_participant(rows, code).participant
            found = rows.execute(
                "SELECT count(*) FROM answers WHERE participant = ?", (participant.number,)
            ).fetchone()[0]
            for table in ("answers", "pages", "played", "notes", "device"):
                rows.execute(f"DELETE FROM {table} WHERE participant = ?", (participant.number,))
            rows.execute("DELETE FROM participants WHERE number = ?", (participant.number,))
            rows.execute("UPDATE study SET withdrawn = withdrawn + 1")
        self.compact()
        return int(found)

    @property
    def withdrawn(self) -> int:
        """How many withdrew."""
        with self._reading() as rows:
            return int(rows.execute("SELECT withdrawn FROM study").fetchone()[0])

    def _set_status(self, code: str, status: str) -> None:
        with self._writing() as rows:
            number = find_participant(rows, code).participant.number
            rows.execute("UPDATE participants SET status = ? WHERE number = ?", (status, number))

    def _check_language(self, language: str) -> None:
        if language not in self.study.languages:
            known = ", ".join(self.study.languages)
            raise ParameterError(f"language must be one of {known}, got {language[:20]!r}")

    def _check_kind(self, rows: sqlite3.Connection, simulated: bool) -> None:
        """Refuse a mixture: answers of people and of simulated participants are never analysed together."""
        if rows.execute("SELECT 1 FROM participants WHERE simulated != ?", (simulated,)).fetchone():
            there, other = (
                ("people", "simulated participants") if simulated else ("simulated participants", "people")
            )
            raise ParameterError(f"{there} take this study here; {other} need a session folder of their own")


def find_participant(rows: sqlite3.Connection, code: str) -> ParticipantRecord:
    """Return who has a code, whatever the case of its letters.

    Raises
    ------
    NobodyError
        If nobody has.
    """
    row = rows.execute(f"{_KNOWN} WHERE code = ? COLLATE NOCASE", (code,)).fetchone()
    if row is None:
        raise UnknownParticipantError(f"no participant has the code {code[:40]!r}")
    return _known(row)


def active(rows: sqlite3.Connection, code: str) -> Participant:
    """Return who has a code and goes on.

    Raises
    ------
    NobodyError, NotNowError
        If nobody has it, or the experimenter ended their session.
    """
    found = find_participant(rows, code)
    found.check_active()
    return found.participant


def everybody(rows: sqlite3.Connection) -> list[ParticipantRecord]:
    """Return all participants by number."""
    return [_known(row) for row in rows.execute(f"{_KNOWN} ORDER BY number").fetchall()]


def _known(row: tuple[Any, ...]) -> ParticipantRecord:
    code, number, language, simulated, session, status = row
    return ParticipantRecord(
        Participant(code, number, language, bool(simulated), session), status == "active"
    )


def checked_code(code: str) -> str:
    """Return a code if it may be one.

    Raises
    ------
    ParameterError
        If it may be a name, or is too short or long.
    """
    if not CODE.fullmatch(code):
        raise ParameterError(
            f"code must be 2 to 16 letters and digits with a digit among them, never a name, got {code[:40]!r}"
        )
    return code


def drawn_code() -> str:
    """Return a code that is easily read and typed and hard to guess: three times a letter and a digit."""
    return "".join(secrets.choice(LETTERS) + secrets.choice(DIGITS) for _ in range(3))
