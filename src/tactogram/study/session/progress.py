"""Progress of a participant: answers so far, the next page, and whether the session may continue."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from tactogram.study.session.participants import ENDED, PageNotOpenError, ParticipantRecord
from tactogram.study.session.sitting import declined, next_page
from tactogram.study.study_file import Study
from tactogram.study.trials import Page, PageAnswers, Participant

State = Literal["going", "done", "declined", "aborted"]
Row = tuple[int, str, str, str]
"""An answered page as the file has it: position from 1, token, responses and facts, both as JSON."""
FIELD, PAGE = "\x1f", "\x1e"
"""What divides a record of pages; in JSON both are escaped."""


@dataclass(frozen=True)
class ParticipantProgress:
    """Answers of a participant, and the next page.

    Parameters
    ----------
    given : tuple of Given
        In order.
    page : Page or None
        None at the end.
    """

    given: tuple[PageAnswers, ...]
    page: Page | None


@dataclass(frozen=True)
class ParticipantState:
    """State of a participant.

    Parameters
    ----------
    known : Known
    ended : bool
        Whether the experimenter ended the study.
    record : str
        Answered pages, as one text.
    way : Way
        What follows from them.
    """

    known: ParticipantRecord
    ended: bool
    record: str
    progress: ParticipantProgress

    @property
    def participant(self) -> Participant:
        """Who it is."""
        return self.known.participant

    @property
    def page(self) -> Page | None:
        """What is shown now; None at the end, and where the experimenter ended it."""
        return self.progress.page if self.state == "going" else None

    @property
    def state(self) -> State:
        """Whether a participant is going on, done, did not agree to take part, or was aborted."""
        if not self.known.active:
            return "aborted"
        if self.progress.page is not None:
            return "aborted" if self.ended else "going"
        return "declined" if declined(self.progress.given) else "done"

    def check_going(self) -> None:
        """Refuse who may not go on, and has not come to the end.

        Raises
        ------
        NotNowError
            If the experimenter ended their session, or the study.
        """
        self.known.check_active()
        if self.state == "aborted":
            raise PageNotOpenError(ENDED)


def way(study: Study, participant: Participant, given: tuple[PageAnswers, ...]) -> ParticipantProgress:
    """Return what follows from the pages that a participant answered."""
    return ParticipantProgress(given, next_page(study, participant, given))


def row_of(position: int, given: PageAnswers) -> Row:
    """Return an answered page as the file has it."""
    return position, given.token, _text(given.responses), _text(given.facts)


def record_of(rows: sqlite3.Connection, participant: Participant) -> str:
    """Return the pages that a participant answered.

    As one text: SQLite makes it in one step, and the interpreter's lock, which each step gives away, is not waited for
    as often as there are pages.
    """
    [record] = rows.execute(
        "SELECT group_concat(position || char(31) || token || char(31) || responses || char(31) || facts, char(30)) "
        "FROM (SELECT * FROM pages WHERE participant = ? ORDER BY position)",
        (participant.number,),
    ).fetchone()
    return record or ""


def extended(record: str, row: Row) -> str:
    """Return a record with a page more."""
    page = FIELD.join(map(str, row))
    return f"{record}{PAGE}{page}" if record else page


def parse_record(record: str) -> tuple[PageAnswers, ...]:
    """Return the pages of a record, in the order in which they were answered."""
    pages = [page.split(FIELD) for page in record.split(PAGE)] if record else []
    pages.sort(key=lambda page: int(page[0]))
    return tuple(
        PageAnswers(token, json.loads(responses), json.loads(facts)) for _, token, responses, facts in pages
    )


def _text(values: Mapping[str, str]) -> str:
    return json.dumps(dict(values), ensure_ascii=False)
