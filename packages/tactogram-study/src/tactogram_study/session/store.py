"""Session store: durable answers to one study, and each participant's progress.

An answer is on the disk before the next page is known. A page is stored once, however often it is sent. The next page
follows from the stored ones in the order of their positions; the clock decides nothing.
"""

from __future__ import annotations

import json
import re
import sqlite3
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError
from tactogram_study.answers import Answer, Answers
from tactogram_study.practice import practice_answers
from tactogram_study.session.device_facts import valid_facts
from tactogram_study.session.file import add_device, ended_at, now_utc, parse_answer
from tactogram_study.session.participants import (
    PageNotOpenError,
    SessionPeople,
    find_participant,
    last_played,
    stored_participants,
)
from tactogram_study.session.progress import (
    NOT_BEGUN,
    ParticipantState,
    State,
    answer_rows,
    declined,
    page_after,
    parse_pages,
    stored_pages,
)
from tactogram_study.stimuli import Stimulus
from tactogram_study.study_file import Study
from tactogram_study.trials import Page, PageAnswers, Participant

CachedState = tuple[Participant, str, tuple[PageAnswers, ...], Page | None]
"""Participant and stored pages, and what was computed from them."""
MOST_CACHED = 1000
"""Participants whose progress is cached between a page's answer and the request for the next."""


@dataclass(frozen=True)
class SubmissionResult:
    """Result of submitting answers; not ``stored`` if the page was answered before, and its first answers stay."""

    stored: bool
    state: ParticipantState

    @property
    def page(self) -> Page | None:
        """Next page, None at the end."""
        return self.state.page


class SessionStore(SessionPeople):
    """The answers to one study in a folder; see `SessionFile` for parameters and errors.

    `SessionPeople` adds the participants and logs to the file, this class pages and answers.
    """

    def __init__(self, folder: Path, study: Study | None = None) -> None:
        super().__init__(folder, study)
        # By number, with what it was computed from: valid only while the file holds the same, whoever writes to it.
        self._cache: dict[int, CachedState] = {}
        self.is_simulated: Callable[[Stimulus], bool] = attrgetter("is_simulated")
        """Whether answers about a stimulus are marked as about a simulated one; `StudyStimuli` knows its files, too."""
        self.limited: Callable[[], Mapping[str, Sequence[str]]] = dict
        """What was limited of stimuli, in sentences by name, which are stored with the answers about them."""

    def participant_state(self, code: str) -> ParticipantState:
        """Return the state of a participant; raise `UnknownParticipantError` if there is none."""
        with self._reading() as rows:
            return self._state(rows, find_participant(rows, code))

    def page(self, code: str) -> Page | None:
        """Return the current page, None at the end; raise `PageNotOpenError` if the experimenter ended the session."""
        state = self.participant_state(code)
        state.check_open()
        return state.page

    def submit(
        self,
        code: str,
        token: str,
        responses: Mapping[str, str],
        *,
        rt_ms: Mapping[str, float] | None = None,
        device: Mapping[str, Any] | None = None,
    ) -> SubmissionResult:
        """Store the answers to a page; they are on the disk on return.

        A second submission, by a double click, the back button or a reload, stores nothing and returns the same.

        ``responses``: by key of the page's questions. ``rt_ms``: by key; ``""`` stands for the page. ``device``: device
        facts: ``{"px_per_mm": 6.1, "refresh_hz": 60}``. Invalid ones are dropped (`valid_facts`); the rest become
        columns such as ``device_px_per_mm``.

        Raises `PageNotOpenError` if the page is neither the current nor an answered one, or the experimenter ended the
        session; `ParameterError` if no participant has the code, or an answer is invalid. Nothing is stored then.
        """
        with self._writing() as rows:
            state = self._state(rows, find_participant(rows, code))
            state.check_open()
            if any(answered.token == token for answered in state.history):
                return SubmissionResult(False, state)
            participant, page = state.participant, state.page
            if page is None or page.token != token:
                now = "at the end" if page is None else f"at page {page.token}"
                raise PageNotOpenError(
                    f"{participant.code} is {now}, got an answer to {token[:60]!r}; reload the page"
                )
            accepted = page.accepted(responses)
            facts = valid_facts(device)
            answers = answer_rows(
                self.study,
                participant,
                page,
                accepted,
                at=now_utc(),
                rt_ms=_valid_times(rt_ms or {}, accepted),
                played=last_played(rows, participant, token),
                device=facts,
                is_simulated=self.is_simulated,
                limited=self.limited(),
            )
            submitted = PageAnswers(token, accepted, page.more)
            history = (*state.history, submitted)
            _insert(rows, participant, len(history), submitted, answers)
            add_device(rows, participant.number, token, facts)
            record = stored_pages(rows, participant)
            following = page_after(self.study, participant, history)
            self._cached(participant, record, history, following)
            return SubmissionResult(True, replace(state, history=history, next_page=following))

    def log_played(
        self, code: str, token: str, slot: str, *, sha256: str, level: str, display: str, gain_db: float = 0.0
    ) -> int:
        """Log playback, before or during it, and return its row, for `complete_played`.

        Raises `PageNotOpenError` if the participant is not at that page.
        """
        if not re.fullmatch("[0-9a-f]{64}", sha256):
            raise ParameterError.must("sha256", "be 64 hexadecimal digits", sha256[:80])
        with self._writing() as rows:
            state = self._state(rows, find_participant(rows, code))
            state.check_open()
            if state.page is None or state.page.token != token:
                raise PageNotOpenError(f"{code} is not at page {token[:60]!r}; reload the page")
            state.page.slot(slot)
            inserted = rows.execute(
                "INSERT INTO played (participant, token, slot, sha256, level, display, gain_db, at) "
                "VALUES (?,?,?,?,?,?,?,?)",
                (state.participant.number, token, slot, sha256, level, display, gain_db, now_utc()),
            )
            return int(inserted.lastrowid or 0)

    def withdraw(self, code: str) -> int:
        """Delete a participant with all their data; see `SessionPeople.withdraw`."""
        try:
            return super().withdraw(code)
        finally:
            self._cache.clear()

    def state(self, code: str) -> State:
        """Return whether a participant continues, is done, declined to take part, or was aborted."""
        return self.participant_state(code).state

    def progress(self) -> list[dict[str, Any]]:
        """Return the progress of each participant, for the experimenter.

        Code, number, status, trials done and in all, practice trials begun, and the time of the last answer.
        """
        with self._reading() as rows:
            return [self._progress(rows, self._state(rows, person)) for person in stored_participants(rows)]

    def answers(self) -> Answers:
        """Return every answer, by participant and in the order given."""
        return Answers(self._answers("ORDER BY participant, position, place"))

    def latest(self, count: int) -> tuple[Answer, ...]:
        """Return the last answers of all participants, newest first, by the order of arrival."""
        return self._answers("ORDER BY rowid DESC LIMIT ?", count)

    @property
    def count(self) -> int:
        """Number of answers."""
        with self._reading() as rows:
            return int(rows.execute("SELECT count(*) FROM answers").fetchone()[0])

    def _answers(self, order: str, *values: int) -> tuple[Answer, ...]:
        with self._reading() as rows:
            stored = rows.execute(f"SELECT row FROM answers {order}", values).fetchall()
        with self._damage_reported():
            return tuple(parse_answer(text) for (text,) in stored)

    def _state(self, rows: sqlite3.Connection, participant: Participant) -> ParticipantState:
        record, cached = stored_pages(rows, participant), self._cache.get(participant.number)
        if cached is None or cached[:2] != (participant, record):
            history = parse_pages(record)
            following = page_after(self.study, participant, history)
            cached = self._cached(participant, record, history, following)
        return ParticipantState(participant, ended_at(rows) is not None, *cached[2:])

    def _cached(
        self, participant: Participant, record: str, history: tuple[PageAnswers, ...], page: Page | None
    ) -> CachedState:
        if len(self._cache) >= MOST_CACHED:
            self._cache.clear()
        self._cache[participant.number] = (participant, record, history, page)
        return self._cache[participant.number]

    def _progress(self, rows: sqlite3.Connection, state: ParticipantState) -> dict[str, Any]:
        participant, page, history = state.participant, state.next_page, state.history
        status = "active" if participant.active else "aborted"
        if status == "active" and not history:
            status = NOT_BEGUN
        elif status == "active" and page is None:
            status = "declined" if declined(history) else "finished"
        trials = {
            answered.token.partition(".")[0] for answered in history if answered.token.startswith("trial-")
        }
        all_complete = page is None or page.step == 1
        return {
            "participant": participant.code,
            "number": participant.number,
            "simulated": participant.simulated,
            "language": participant.language,
            "status": status,
            "page": None if page is None else page.token,
            "trials": len(trials) - (0 if all_complete else 1),
            "of": self.study.trials,
            "practice": len({answered.token.partition(".")[0] for answered in practice_answers(history)}),
            "last": _last_time(rows, participant),
        }


def _valid_times(rt_ms: Mapping[str, float], accepted: Mapping[str, str]) -> dict[str, float]:
    """Return the times that are possible, without those of a broken or changed clock."""
    known = {key: value for key, value in rt_ms.items() if key == "" or key in accepted}
    return {key: float(value) for key, value in known.items() if 0 <= value < 86_400_000}


def _insert(
    rows: sqlite3.Connection,
    participant: Participant,
    position: int,
    page: PageAnswers,
    answers: Sequence[Answer],
) -> None:
    number = participant.number
    written = (json.dumps(dict(values), ensure_ascii=False) for values in (page.responses, page.facts))
    rows.execute(
        "INSERT INTO pages (participant, position, token, responses, facts) VALUES (?,?,?,?,?)",
        (number, position, page.token, *written),
    )
    rows.executemany(
        "INSERT INTO answers (participant, position, place, row) VALUES (?,?,?,?)",
        [(number, position, index, json.dumps(vars(answer))) for index, answer in enumerate(answers)],
    )


def _last_time(rows: sqlite3.Connection, participant: Participant) -> str | None:
    """Return the time of the last answer, by the clock of then; None if there is none."""
    row = rows.execute(
        "SELECT row FROM answers WHERE participant = ? ORDER BY position DESC LIMIT 1", (participant.number,)
    ).fetchone()
    return None if row is None else parse_answer(row[0]).at
