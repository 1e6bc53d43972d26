"""Progress of a participant: answers so far, the next page, and whether the session may continue."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from tactogram.study.session.participants import ENDED, PageNotOpenError, ParticipantRecord
from tactogram.study.session.salvage import UnreadableRowError, parse_object
from tactogram.study.session.sitting import declined, next_page
from tactogram.study.study_file import Study
from tactogram.study.trials import Page, PageAnswers, Participant

State = Literal["going", "done", "declined", "aborted"]
PageRow = tuple[int, str, str, str]
"""An answered page as stored: position from 1, token, responses and facts, both as JSON."""
FIELD, PAGE = "\x1f", "\x1e"
"""Separators of a record of pages; JSON escapes both."""


@dataclass(frozen=True)
class ParticipantProgress:
    """Answers of a participant in order, and the next page; None at the end."""

    history: tuple[PageAnswers, ...]
    page: Page | None


@dataclass(frozen=True)
class ParticipantState:
    """State of a participant: as stored, with the answered pages as one text and the resulting progress."""

    stored: ParticipantRecord
    study_ended: bool
    page_record: str
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


def page_row(position: int, answers: PageAnswers) -> PageRow:
    """Return an answered page as it is stored."""
    return position, answers.token, _json(answers.responses), _json(answers.facts)


def stored_pages(rows: sqlite3.Connection, participant: Participant) -> str:
    """Return the pages that a participant answered, as a record.

    As one text: SQLite makes it in one step, while each step of a query releases the interpreter's lock and waits for
    it again.
    """
    [record] = rows.execute(
        "SELECT group_concat(position || char(31) || token || char(31) || responses || char(31) || facts, char(30)) "
        "FROM (SELECT * FROM pages WHERE participant = ? ORDER BY position)",
        (participant.number,),
    ).fetchone()
    return record or ""


def with_page(record: str, row: PageRow) -> str:
    """Return a record with one more page."""
    page = FIELD.join(map(str, row))
    return f"{record}{PAGE}{page}" if record else page


def parse_pages(record: str) -> tuple[PageAnswers, ...]:
    """Return the pages of a record in order; raise `UnreadableRowError` for one that is not readable."""
    pages = [page.split(FIELD) for page in record.split(PAGE)] if record else []
    if not all(len(page) == 4 and page[0].isdecimal() for page in pages):
        raise UnreadableRowError("a row of pages is not readable")
    pages.sort(key=lambda page: int(page[0]))
    return tuple(
        PageAnswers(token, parse_object(responses), parse_object(facts))
        for _, token, responses, facts in pages
    )


def _json(values: Mapping[str, str]) -> str:
    return json.dumps(dict(values), ensure_ascii=False)
