"""Progress of a participant: answers so far, the next page, whether the session may continue, and states as text."""

from __future__ import annotations

import json
import sqlite3
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Literal

from tactogram_study.session.file import UnreadableRowError, parse_object
from tactogram_study.session.participants import ENDED, PageNotOpenError, check_active
from tactogram_study.session.sitting import declined, next_page
from tactogram_study.study_file import Study
from tactogram_study.trials import History, Page, PageAnswers, Participant

NOT_BEGUN = "not begun"
STATES: Mapping[str, str] = {
    "finished": "to the end",
    "active": "begun, and not at the end",
    NOT_BEGUN: "enrolled, and answered no page yet",
    "aborted": "ended by the experimenter",
    "declined": "did not agree to take part",
}
"""Meaning of the states in `SessionStore.progress` and exports."""


def status_label(status: str) -> str:
    """Return the label of a state on pages and in reports."""
    return "going on" if status == "active" else status


def status_counts(statuses: Iterable[str]) -> str:
    """Return counts in the order of `STATES`, then of states in foreign tables: ``1 finished, 2 going on``."""
    counts = Counter(statuses)
    return ", ".join(
        f"{counts[status]} {status_label(status)}"
        for status in dict.fromkeys([*STATES, *counts])
        if counts[status]
    )


State = Literal["going", "done", "declined", "aborted"]


@dataclass(frozen=True)
class ParticipantState:
    """State of a participant: answered pages in order, and the page that follows from them, None at the end."""

    participant: Participant
    study_ended: bool
    history: tuple[PageAnswers, ...]
    next_page: Page | None

    @property
    def page(self) -> Page | None:
        """Current page; None at the end, and where the experimenter ended the session."""
        return self.next_page if self.state == "going" else None

    @property
    def state(self) -> State:
        """Whether the participant continues, is done, declined to take part, or was aborted."""
        if not self.participant.active or (self.next_page is not None and self.study_ended):
            return "aborted"
        if self.next_page is not None:
            return "going"
        return "declined" if declined(self.history) else "done"

    def check_open(self) -> None:
        """Raise `PageNotOpenError` if the experimenter ended the participant's session, or the study before its end."""
        check_active(self.participant)
        if self.state == "aborted":
            raise PageNotOpenError(ENDED)


def page_after(study: Study, participant: Participant, history: History) -> Page | None:
    """Return what follows from the answered pages; raise `UnreadableRowError` if they do not fit the study."""
    try:
        return next_page(study, participant, history)
    except (KeyError, IndexError) as error:
        raise UnreadableRowError(
            f"the pages of {participant.code} do not fit the study: {error!r}"
        ) from error


def stored_pages(rows: sqlite3.Connection, participant: Participant) -> str:
    """Return the pages that a participant answered, as JSON.

    As one text: SQLite makes it in one step, while each step of a query releases the interpreter's lock and waits for
    it again.
    """
    [record] = rows.execute(
        "SELECT json_group_array(json_array(position, token, responses, facts)) FROM pages WHERE participant = ?",
        (participant.number,),
    ).fetchone()
    return str(record)


def parse_pages(record: str) -> tuple[PageAnswers, ...]:
    """Return the pages of `stored_pages` in order; raise `UnreadableRowError` for one that is not readable."""
    return tuple(
        PageAnswers(token, parse_object(responses), parse_object(facts))
        for _, token, responses, facts in sorted(json.loads(record))
    )
