"""Answers on the disk before anything else happens: one SQLite file for each study.

When `SessionStore.submit` returns, its page is on the disk (`SessionFile` says how). A page is stored once, whatever is
sent again. What is next follows from what is stored, in the order of the rows' numbers; no clock decides anything.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from tactogram.errors import ParameterError
from tactogram.study.answers import Answer, Answers
from tactogram.study.device_facts import kept_facts
from tactogram.study.practice import practised
from tactogram.study.session_file import add_device, now_utc
from tactogram.study.session_logs import SessionLogs
from tactogram.study.sitting import answers_to, declined, next_page
from tactogram.study.trials import Given, Page, Participant

State = Literal["going", "done", "declined", "aborted"]


@dataclass(frozen=True)
class Submitted:
    """What became of answers that were sent.

    Parameters
    ----------
    stored : bool
        False if the page was answered before; what was stored then stays.
    page : Page or None
        Next one, None at the end.
    """

    stored: bool
    page: Page | None


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

    def page(self, code: str) -> Page | None:
        """Return what a participant is shown now; None at the end.

        Raises
        ------
        ParameterError
            If nobody has the code, or the session was ended by the experimenter.
        """
        participant = self.participant(code)
        self._check_active(participant)
        page = next_page(self.study, participant, self._given(participant))
        if page is not None:
            self._check_going()
        return page

    def submit(
        self,
        code: str,
        token: str,
        responses: Mapping[str, str],
        *,
        rt_ms: Mapping[str, float] | None = None,
        device: Mapping[str, Any] | None = None,
    ) -> Submitted:
        """Store the answers to a page; they are on the disk when this returns.

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
            kept is left out (see `tactogram.study.device_facts`); the rest stands in the rows, as ``device_px_per_mm``.

        Raises
        ------
        ParameterError
            If the page is neither the present one nor an answered one, or an answer is none. Nothing is stored then.
        """
        participant = self.participant(code)
        given = self._given(participant)
        if any(one.token == token for one in given):
            return Submitted(False, self.page(code))
        self._check_active(participant)
        page = next_page(self.study, participant, given)
        if page is None or page.token != token:
            now = "at the end" if page is None else f"at page {page.token}"
            raise ParameterError(
                f"{participant.code} is {now}, got an answer to {token[:60]!r}; reload the page"
            )
        self._check_going()
        accepted = page.accepted(responses)
        facts = kept_facts(device)
        answers = answers_to(
            self.study,
            participant,
            page,
            accepted,
            at=now_utc(),
            rt_ms=_times(rt_ms or {}, accepted),
            played=self.played(participant.code, token),
            device=facts,
        )
        new = Given(token, accepted, page.more)
        if self._store(participant, len(given) + 1, new, answers, facts):
            return Submitted(True, next_page(self.study, participant, [*given, new]))
        return Submitted(False, self.page(code))

    def log_played(
        self, code: str, token: str, slot: str, *, sha256: str, level: str, display: str, gain_db: float = 0.0
    ) -> None:
        """Note what was played, before or while it is; it is on the disk when this returns.

        Raises
        ------
        ParameterError
            If the participant is not at that page, or it has no such slot.
        """
        page = self.page(code)
        if page is None or page.token != token:
            raise ParameterError(f"{code} is not at page {token[:60]!r}; reload the page")
        page.slot(slot)
        if not re.fullmatch("[0-9a-f]{64}", sha256):
            raise ParameterError(f"sha256 must be 64 hexadecimal digits, got {sha256[:80]!r}")
        participant = self.participant(code)
        with self._writing() as rows:
            number = self._still_there(participant)
            rows.execute(
                "INSERT INTO played (participant, token, slot, sha256, level, display, gain_db, at) "
                "VALUES (?,?,?,?,?,?,?,?)",
                (number, token, slot, sha256, level, display, gain_db, now_utc()),
            )

    def state(self, code: str) -> State:
        """Return whether a participant is going on, done, did not agree to take part, or was aborted.

        Raises
        ------
        ParameterError
            If nobody has the code.
        """
        participant = self.participant(code)
        if self._status(participant) != "active":
            return "aborted"
        given = self._given(participant)
        if next_page(self.study, participant, given) is not None:
            return "aborted" if self.ended else "going"
        return "declined" if declined(given) else "done"

    def progress(self) -> list[dict[str, Any]]:
        """Return where each participant stands, for the experimenter.

        Code, number, status, trials done and in all, practice trials begun, and when the last answer came.
        """
        found = []
        for participant in self.participants():
            given = self._given(participant)
            status = self._status(participant)
            page = next_page(self.study, participant, given)
            if status == "active" and page is None:
                status = "declined" if declined(given) else "finished"
            trials = {one.token.partition(".")[0] for one in given if one.token.startswith("trial-")}
            finished_all = page is None or page.step == 1
            found.append(
                {
                    "participant": participant.code,
                    "number": participant.number,
                    "simulated": participant.simulated,
                    "language": participant.language,
                    "status": status,
                    "page": None if page is None else page.token,
                    "trials": len(trials) - (0 if finished_all else 1),
                    "of": self.study.trials,
                    "practice": len({one.token.partition(".")[0] for one in practised(given)}),
                    "last": self._last(participant),
                }
            )
        return found

    def answers(self) -> Answers:
        """Return every answer, by participant and in the order given."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT row FROM answers ORDER BY participant, position, place"
            ).fetchall()
        return Answers(tuple(_answer(json.loads(row[0])) for row in rows))

    def latest(self, count: int) -> tuple[Answer, ...]:
        """Return the last answers of all participants, newest first; by the order in which they came, not the clock."""
        with self._lock:
            rows = self._connection.execute(
                "SELECT row FROM answers ORDER BY rowid DESC LIMIT ?", (count,)
            ).fetchall()
        return tuple(_answer(json.loads(row[0])) for row in rows)

    @property
    def count(self) -> int:
        """How many answers there are."""
        with self._lock:
            return int(self._connection.execute("SELECT count(*) FROM answers").fetchone()[0])

    def _given(self, participant: Participant) -> list[Given]:
        with self._lock:
            rows = self._connection.execute(
                "SELECT token, responses, facts FROM pages WHERE participant = ? ORDER BY position",
                (participant.number,),
            ).fetchall()
        return [Given(token, json.loads(responses), json.loads(facts)) for token, responses, facts in rows]

    def _store(
        self,
        participant: Participant,
        position: int,
        given: Given,
        answers: Sequence[Answer],
        device: Mapping[str, Any],
    ) -> bool:
        """Store a page and its rows; return False if another got there first."""
        number = participant.number
        with self._writing() as rows:
            self._still_there(participant)
            there = rows.execute(
                "SELECT 1 FROM pages WHERE participant = ? AND position = ?", (number, position)
            )
            if there.fetchone():
                return False
            text = json.dumps(given.responses, ensure_ascii=False)
            facts = json.dumps(given.facts, ensure_ascii=False)
            rows.execute(
                "INSERT INTO pages (participant, position, token, responses, facts) VALUES (?,?,?,?,?)",
                (number, position, given.token, text, facts),
            )
            rows.executemany(
                "INSERT INTO answers (participant, position, place, row) VALUES (?,?,?,?)",
                [(number, position, place, json.dumps(asdict(row))) for place, row in enumerate(answers)],
            )
            add_device(rows, number, given.token, device)
        return True

    def _last(self, participant: Participant) -> str | None:
        """Return when the last answer came, by the clock of then; None if none has."""
        with self._lock:
            row = self._connection.execute(
                "SELECT row FROM answers WHERE participant = ? ORDER BY position DESC LIMIT 1",
                (participant.number,),
            ).fetchone()
        return None if row is None else str(json.loads(row[0])["at"])


def _times(rt_ms: Mapping[str, float], accepted: Mapping[str, str]) -> dict[str, float]:
    """Return the times that can be: what a broken or changed clock made of the others is left out."""
    known = {key: value for key, value in rt_ms.items() if key == "" or key in accepted}
    return {key: float(value) for key, value in known.items() if 0 <= value < 86_400_000}


def _answer(values: dict[str, Any]) -> Answer:
    return Answer(**values)
