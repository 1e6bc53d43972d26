"""One participant's way through a study: consent, questions, practice, trials, questions, end; and its progress.

The way is a pure function of the study, the participant and the answers so far.
"""

from __future__ import annotations

import hashlib
import json
import math
import sqlite3
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter
from typing import Any, Literal

from tactogram_study.answers import Answer
from tactogram_study.practice import MARK, TOKEN, practice_answers
from tactogram_study.questions import AnswerOption, Question
from tactogram_study.session.device_facts import device_columns
from tactogram_study.session.file import UnreadableRowError, parse_object
from tactogram_study.session.participants import ENDED, PageNotOpenError, check_active
from tactogram_study.stimuli import Stimulus
from tactogram_study.study_file import Study
from tactogram_study.trials import History, Page, PageAnswers, PageQuestion, Participant
from tactogram_study.wording import default_text

CONSENT, BEFORE, AFTER = "consent", "before", "after"
"""Tokens of the pages around the trials."""


def next_page(study: Study, participant: Participant, history: History) -> Page | None:
    """Return the page after ``history``, all answered pages of the participant in order; None at the end."""
    tokens = [answered.token for answered in history]
    if CONSENT not in tokens:
        consent = {"consent_sha256": consent_sha256(study)}
        return Page(
            CONSENT, "consent", (PageQuestion(_consent_question()),), text=study.consent, more=consent
        )
    if declined(history):
        return None
    if study.before and BEFORE not in tokens:
        return Page(BEFORE, "questions", tuple(map(PageQuestion, study.before)))
    practice = practice_answers(history)
    around = (CONSENT, BEFORE, AFTER)
    trials = [page for page in history if page.token not in around and not page.token.startswith(TOKEN)]
    if study.practice is not None and not trials:
        page = study.practice.next_page(study.design, study.setting, participant, practice)
        if page is not None:
            return page
    page = study.design.next_page(study.setting, participant, trials)
    if page is not None and study.practice is not None and not trials:
        return study.practice.first_trial(page, study.design, study.setting, participant, practice)
    if page is not None:
        due = study.rest_every and page.trial > 1 and page.step == 1
        return replace(page, rest=bool(due and (page.trial - 1) % study.rest_every == 0))
    if study.after and AFTER not in tokens:
        return Page(AFTER, "questions", tuple(map(PageQuestion, study.after)))
    return None


def _consent_question() -> Question:
    options = (
        AnswerOption(value=value, text=default_text(f"consent_{value}")) for value in ("agreed", "declined")
    )
    return Question(
        id="consent", text=default_text("consent_question"), kind="choice", options=tuple(options)
    )


def declined(history: History) -> bool:
    """Return whether the participant declined to take part."""
    return any(page.token == CONSENT and page.responses.get("consent") != "agreed" for page in history)


def consent_sha256(study: Study) -> str:
    """Return the hash of the consent text in all languages of the study."""
    text = study.consent.model_dump_json(context={"languages": study.languages})
    return hashlib.sha256(text.encode()).hexdigest()


def answer_rows(
    study: Study,
    participant: Participant,
    page: Page,
    responses: Mapping[str, str],
    *,
    at: str,
    rt_ms: Mapping[str, float] | None = None,
    played: Mapping[str, str] | None = None,
    device: Mapping[str, Any] | None = None,
    is_simulated: Callable[[Stimulus], bool] = attrgetter("is_simulated"),
    limited: Mapping[str, Sequence[str]] | None = None,
) -> tuple[Answer, ...]:
    """Return the rows of the accepted answers to a page.

    Response times are by key, with ``""`` for the page; ``played`` are hashes of the samples by slot; ``limited`` are
    sentences on stimuli, by name.
    """
    columns = device_columns(device or {})
    times, hashes = rt_ms or {}, played or {}
    presented = [p.stimulus for p in page.presented if p.stimulus is not None and p.stimulus.is_played]
    simulated = any(p.stimulus is not None and is_simulated(p.stimulus) for p in page.presented)
    shown = dict.fromkeys(p.stimulus.name for p in page.presented if p.stimulus is not None)
    said = "; ".join(f"{name}: {line}" for name in shown for line in (limited or {}).get(name, ()))
    levels = dict.fromkeys(stimulus.level or study.level for stimulus in presented)
    displays = dict.fromkeys(stimulus.display or study.display for stimulus in presented)
    rows = []
    for question in page.questions:
        response = responses[question.key]
        low, high = _scale(question)
        rows.append(
            Answer(
                study=study.name,
                participant=participant.code,
                session=participant.session,
                block=page.block,
                trial=page.trial,
                repeat=page.repeat,
                design=_design(page),
                question=question.question.id,
                condition=question.condition,
                stimulus=question.stimulus,
                other=question.other,
                side=question.side,
                answer=response,
                value=_number(question, response),
                correct=response == question.right if question.right else None,
                scale_low=low,
                scale_high=high,
                rt_ms=times.get(question.key, times.get("", math.nan)),
                at=at,
                played_sha256=_played(question, hashes),
                level="+".join(levels),
                display="+".join(displays),
                seed=study.seed,
                simulated=participant.simulated,
                more={
                    "token": page.token,
                    "step": str(page.step),
                    **({"other_condition": question.other_condition} if question.other else {}),
                    **({MARK: page.kind} if page.practice else {}),
                    **({"simulated_stimuli": "true"} if simulated else {}),
                    **({"limited_stimuli": said} if said else {}),
                    **page.more,
                    **columns,
                },
            )
        )
    return tuple(rows)


def _number(question: PageQuestion, response: str) -> float:
    if response in question.values:
        return question.values[response]
    numeric = question.question.kind in ("steps", "vas", "number")
    return float(response) if numeric and response else math.nan


def _scale(question: PageQuestion) -> tuple[float, float]:
    """Return the ends of the scale; of a choice between no and yes, 0 and 1."""
    values = question.values.values()
    if values and not question.right and len(set(values)) == 2:
        return min(values), max(values)
    return question.question.low, question.question.high


def _played(question: PageQuestion, hashes: Mapping[str, str]) -> str:
    if question.slot:
        return hashes.get(question.slot, "")
    return "+".join(hashes[slot] for slot in ("", "A", "B", "X") if hashes.get(slot))


def _design(page: Page) -> str:
    if page.practice:
        return MARK
    return "questions" if page.kind == "consent" else page.kind


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
