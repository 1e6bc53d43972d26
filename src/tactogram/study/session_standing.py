"""Where a participant of a session is: what they answered, what is next, and whether they may go on."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from tactogram.study.session_people import ENDED, Known, NotNowError
from tactogram.study.sitting import declined, next_page
from tactogram.study.study_file import Study
from tactogram.study.trials import Given, Page, Participant

State = Literal["going", "done", "declined", "aborted"]
Row = tuple[str, str, str]
"""An answered page as the file has it: token, responses and facts, both as JSON."""


@dataclass(frozen=True)
class Way:
    """What a participant answered, and what is next.

    Parameters
    ----------
    given : tuple of Given
        In order.
    page : Page or None
        None at the end.
    """

    given: tuple[Given, ...]
    page: Page | None


@dataclass(frozen=True)
class Standing:
    """Where a participant is.

    Parameters
    ----------
    known : Known
    ended : bool
        Whether the experimenter ended the study.
    rows : tuple of Row
        Answered pages, in order.
    way : Way
        What follows from them.
    """

    known: Known
    ended: bool
    rows: tuple[Row, ...]
    way: Way

    @property
    def participant(self) -> Participant:
        """Who it is."""
        return self.known.participant

    @property
    def page(self) -> Page | None:
        """What is shown now; None at the end, and where the experimenter ended it."""
        return self.way.page if self.state == "going" else None

    @property
    def state(self) -> State:
        """Whether a participant is going on, done, did not agree to take part, or was aborted."""
        if not self.known.active:
            return "aborted"
        if self.way.page is not None:
            return "aborted" if self.ended else "going"
        return "declined" if declined(self.way.given) else "done"

    def check_going(self) -> None:
        """Refuse who may not go on, and has not come to the end.

        Raises
        ------
        NotNowError
            If the experimenter ended their session, or the study.
        """
        self.known.check_active()
        if self.state == "aborted":
            raise NotNowError(ENDED)


def way(study: Study, participant: Participant, rows: tuple[Row, ...]) -> Way:
    """Return what follows from the pages that a participant answered."""
    # Read as one text: an hour's hundreds of pages are read again at every answer.
    texts = json.loads(f"[{','.join(f'[{responses},{facts}]' for _, responses, facts in rows)}]")
    given = tuple(Given(row[0], *both) for row, both in zip(rows, texts, strict=True))
    return Way(given, next_page(study, participant, given))


def row_of(given: Given) -> Row:
    """Return an answered page as the file has it."""
    return given.token, _text(given.responses), _text(given.facts)


def rows_of(rows: sqlite3.Connection, participant: Participant) -> tuple[Row, ...]:
    """Return the pages that a participant answered, in order."""
    found = rows.execute(
        "SELECT token, responses, facts FROM pages WHERE participant = ? ORDER BY position",
        (participant.number,),
    )
    return tuple(found.fetchall())


def _text(values: Mapping[str, str]) -> str:
    return json.dumps(dict(values), ensure_ascii=False)
