"""Progress of a participant: answers so far, the next page, and whether the session may continue."""

from __future__ import annotations

import json
import sqlite3
from dataclasses import dataclass
from typing import Literal

from tactogram_study.session.participants import ENDED, PageNotOpenError, ParticipantRecord
from tactogram_study.session.salvage import UnreadableRowError, parse_object
from tactogram_study.session.sitting import declined, next_page
from tactogram_study.study_file import Study
from tactogram_study.trials import Page, PageAnswers, Participant

State = Literal["going", "done", "declined", "aborted"]


@dataclass(frozen=True)
class ParticipantProgress:
    """Answers of a participant in order, and the next page; None at the end."""

    history: tuple[PageAnswers, ...]
    page: Page | None


@dataclass(frozen=True)
class ParticipantState:
    """State of a participant as stored, with the progress that follows from the answered pages."""

    stored: ParticipantRecord
    study_ended: bool
    progress: ParticipantProgress

    @property
    def participant(self) -> Participant:
        """The participant."""
        return self.stored.participant

    @property
    def page(self) -> Page | None:
        """Current page; None at the end, and where the experimenter ended the session."""
        return self.progress.page if self.state == "going" else None

    @property
    def state(self) -> State:
        """Whether the participant continues, is done, declined to take part, or was aborted."""
        if not self.stored.active:
            return "aborted"
        if self.progress.page is not None:
            return "aborted" if self.study_ended else "going"
        return "declined" if declined(self.progress.history) else "done"

    def check_open(self) -> None:
        """Raise `PageNotOpenError` if the experimenter ended the participant's session, or the study before its end."""
        self.stored.check_active()
        if self.state == "aborted":
            raise PageNotOpenError(ENDED)


def progress_after(
    study: Study, participant: Participant, history: tuple[PageAnswers, ...]
) -> ParticipantProgress:
    """Return what follows from the answered pages; raise `UnreadableRowError` if they do not fit the study."""
    try:
        return ParticipantProgress(history, next_page(study, participant, history))
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
