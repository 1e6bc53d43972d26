"""Answers on the disk before anything else happens: one SQLite file for each study.

When `SessionStore.submit` returns, its page is on the disk (`SessionFile` says how); where it is called within
`SessionFile.together`, when that returns. A page is stored once, whatever is sent again. What is next follows from what
is stored, in the order of the rows' numbers; no clock decides anything.
"""

from __future__ import annotations

import json
import re
import sqlite3
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram.study.answers import Answer, Answers
from tactogram.study.practice import practice_answers
from tactogram.study.session.device_facts import kept_facts
from tactogram.study.session.file import add_device, ended_at, now_utc
from tactogram.study.session.logs import SessionLogs, last_played
from tactogram.study.session.participants import (
    PageNotOpenError,
    ParticipantRecord,
    everybody,
    find_participant,
)
from tactogram.study.session.progress import (
    ParticipantProgress,
    ParticipantState,
    Row,
    State,
    extended,
    parse_record,
    record_of,
    row_of,
    way,
)
from tactogram.study.session.sitting import answer_rows, declined
from tactogram.study.session.states import NOT_BEGUN
from tactogram.study.study_file import Study
from tactogram.study.trials import Page, PageAnswers, Participant

MOST_WAYS = 1000
"""Participants of whom what is next is kept: it is asked for as a page is answered, and as the next one is."""


@dataclass(frozen=True)
class SubmissionResult:
    """Result of sending answers.

    Parameters
    ----------
    stored : bool
        False if the page was answered before; what was stored then stays.
    standing : Standing
        Where the participant is now.
    """

    stored: bool
    standing: ParticipantState

    @property
    def page(self) -> Page | None:
        """Next one, None at the end."""
        return self.standing.page


class SessionStore(SessionLogs):
    """The answers to one study in a folder; safe for several threads and processes at once.

    Each of the classes that it rests on adds one thing to the file: `SessionPeople` who takes part, `SessionLogs` what
    is kept beside answers, this one pages and answers.

    Parameters
    ----------
    folder : Path
    study : Study, optional
        Needed for a folder that is new; else it must be the one that was begun.

    Raises
    ------
    DataError
        If the folder holds another study, or a file that is no session store.
    """

    def __init__(self, folder: Path, study: Study | None = None) -> None:
        super().__init__(folder, study)
        # By number, with what each follows from: it counts only while the file says the same, whoever wrote there.
        self._ways: dict[int, tuple[Participant, str, ParticipantProgress]] = {}

    def standing(self, code: str) -> ParticipantState:
        """Return where a participant is.

        Raises
        ------
        NobodyError
            If nobody has the code.
        """
        with self._reading() as rows:
            return self._standing(rows, find_participant(rows, code))

    def page(self, code: str) -> Page | None:
        """Return what a participant is shown now; None at the end.

        Raises
        ------
        ParameterError
            If nobody has the code, or the session was ended by the experimenter.
        """
        standing = self.standing(code)
        standing.check_going()
        return standing.page

    def submit(
        self,
        code: str,
        token: str,
        responses: Mapping[str, str],
        *,
        rt_ms: Mapping[str, float] | None = None,
        device: Mapping[str, Any] | None = None,
    ) -> SubmissionResult:
        """Store the answers to a page; they are on the disk when this returns, or, within `together`, when that does.

        Sent again, by a double click, the back button or a reload, it stores nothing and answers the same.

        Parameters
        ----------
        code, token : str
            Whose, and to which page.
        responses : mapping from str to str
            By the keys of the page's questions.
        rt_ms : mapping from str to float, optional
            By key; ``""`` stands for the page.
        device : mapping, optional
            What the device says of itself and of this page: ``{"px_per_mm": 6.1, "refresh_hz": 60}``. What cannot be
            kept is left out (see `study.session.device_facts`); the rest stands in the rows, as ``device_px_per_mm``.

        Raises
        ------
        NotNowError
            If the page is neither the present one nor an answered one, or the experimenter ended the session.
        ParameterError
            If nobody has the code, or an answer is none. Nothing is stored then.
        """
        with self._writing() as rows:
            standing = self._standing(rows, find_participant(rows, code))
            standing.check_going()
            if any(one.token == token for one in standing.progress.given):
                return SubmissionResult(False, standing)
            participant, page = standing.participant, standing.page
            if page is None or page.token != token:
                now = "at the end" if page is None else f"at page {page.token}"
                raise PageNotOpenError(
                    f"{participant.code} is {now}, got an answer to {token[:60]!r}; reload the page"
                )
            accepted = page.accepted(responses)
            facts = kept_facts(device)
            answers = answer_rows(
                self.study,
                participant,
                page,
                accepted,
                at=now_utc(),
                rt_ms=_times(rt_ms or {}, accepted),
                played=last_played(rows, participant, token),
                device=facts,
            )
            new = PageAnswers(token, accepted, page.more)
            row = row_of(len(standing.progress.given) + 1, new)
            _store(rows, participant, row, answers)
            add_device(rows, participant.number, token, facts)
            return SubmissionResult(True, self._further(standing, new, row))

    def log_played(
        self, code: str, token: str, slot: str, *, sha256: str, level: str, display: str, gain_db: float = 0.0
    ) -> None:
        """Note what was played, before or while it is; it is on the disk when this returns.

        Raises
        ------
        NotNowError
            If the participant is not at that page.
        ParameterError
            If nobody has the code, or the page has no such slot.
        """
        if not re.fullmatch("[0-9a-f]{64}", sha256):
            raise ParameterError(f"sha256 must be 64 hexadecimal digits, got {sha256[:80]!r}")
        with self._writing() as rows:
            standing = self._standing(rows, find_participant(rows, code))
            standing.check_going()
            if standing.page is None or standing.page.token != token:
                raise PageNotOpenError(f"{code} is not at page {token[:60]!r}; reload the page")
            standing.page.slot(slot)
            rows.execute(
                "INSERT INTO played (participant, token, slot, sha256, level, display, gain_db, at) "
                "VALUES (?,?,?,?,?,?,?,?)",
                (standing.participant.number, token, slot, sha256, level, display, gain_db, now_utc()),
            )

    def withdraw(self, code: str) -> int:
        """Delete a participant and everything that is kept of them; see `SessionPeople.withdraw`."""
        try:
            return super().withdraw(code)
        finally:
            self._ways.clear()

    def state(self, code: str) -> State:
        """Return whether a participant is going on, done, did not agree to take part, or was aborted.

        Raises
        ------
        ParameterError
            If nobody has the code.
        """
        return self.standing(code).state

    def progress(self) -> list[dict[str, Any]]:
        """Return where each participant stands, for the experimenter.

        Code, number, status, trials done and in all, practice trials begun, and when the last answer came.
        """
        with self._reading() as rows:
            return [self._progress(rows, self._standing(rows, one)) for one in everybody(rows)]

    def answers(self) -> Answers:
        """Return every answer, by participant and in the order given."""
        with self._reading() as rows:
            found = rows.execute("SELECT row FROM answers ORDER BY participant, position, place").fetchall()
        return Answers(tuple(_answer(row) for row in found))

    def latest(self, count: int) -> tuple[Answer, ...]:
        """Return the last answers of all participants, newest first; by the order in which they came, not the clock."""
        with self._reading() as rows:
            found = rows.execute("SELECT row FROM answers ORDER BY rowid DESC LIMIT ?", (count,)).fetchall()
        return tuple(_answer(row) for row in found)

    @property
    def count(self) -> int:
        """How many answers there are."""
        with self._reading() as rows:
            return int(rows.execute("SELECT count(*) FROM answers").fetchone()[0])

    def _standing(self, rows: sqlite3.Connection, one: ParticipantRecord) -> ParticipantState:
        participant, record = one.participant, record_of(rows, one.participant)
        kept = self._ways.get(participant.number)
        if kept is not None and kept[:2] == (participant, record):
            found = kept[2]
        else:
            found = self._kept(participant, record, way(self.study, participant, parse_record(record)))
        return ParticipantState(one, ended_at(rows) is not None, record, found)

    def _further(self, standing: ParticipantState, new: PageAnswers, row: Row) -> ParticipantState:
        """Return where a participant is after another page."""
        participant, record = standing.participant, extended(standing.record, row)
        found = way(self.study, participant, (*standing.progress.given, new))
        return replace(standing, record=record, progress=self._kept(participant, record, found))

    def _kept(self, participant: Participant, record: str, found: ParticipantProgress) -> ParticipantProgress:
        if len(self._ways) >= MOST_WAYS:
            self._ways.clear()
        self._ways[participant.number] = (participant, record, found)
        return found

    def _progress(self, rows: sqlite3.Connection, standing: ParticipantState) -> dict[str, Any]:
        participant, page, given = standing.participant, standing.progress.page, standing.progress.given
        status = "active" if standing.known.active else "aborted"
        if status == "active" and not given:
            status = NOT_BEGUN
        elif status == "active" and page is None:
            status = "declined" if declined(given) else "finished"
        trials = {one.token.partition(".")[0] for one in given if one.token.startswith("trial-")}
        finished_all = page is None or page.step == 1
        return {
            "participant": participant.code,
            "number": participant.number,
            "simulated": participant.simulated,
            "language": participant.language,
            "status": status,
            "page": None if page is None else page.token,
            "trials": len(trials) - (0 if finished_all else 1),
            "of": self.study.trials,
            "practice": len({one.token.partition(".")[0] for one in practice_answers(given)}),
            "last": _last(rows, participant),
        }


def _times(rt_ms: Mapping[str, float], accepted: Mapping[str, str]) -> dict[str, float]:
    """Return the times that can be: what a broken or changed clock made of the others is left out."""
    known = {key: value for key, value in rt_ms.items() if key == "" or key in accepted}
    return {key: float(value) for key, value in known.items() if 0 <= value < 86_400_000}


def _store(rows: sqlite3.Connection, participant: Participant, row: Row, answers: Sequence[Answer]) -> None:
    number, position = participant.number, row[0]
    rows.execute(
        "INSERT INTO pages (participant, position, token, responses, facts) VALUES (?,?,?,?,?)",
        (number, *row),
    )
    rows.executemany(
        "INSERT INTO answers (participant, position, place, row) VALUES (?,?,?,?)",
        [(number, position, place, json.dumps(vars(one))) for place, one in enumerate(answers)],
    )


def _last(rows: sqlite3.Connection, participant: Participant) -> str | None:
    """Return when the last answer came, by the clock of then; None if none has."""
    row = rows.execute(
        "SELECT row FROM answers WHERE participant = ? ORDER BY position DESC LIMIT 1", (participant.number,)
    ).fetchone()
    return None if row is None else str(json.loads(row[0])["at"])


def _answer(row: tuple[str]) -> Answer:
    return Answer(**json.loads(row[0]))
