"""Simulated participants: programs that take a study as people do, with or without a true effect.

They answer through the interface of the participant pages, and each of their rows is marked as simulated. They test
pages, store and analysis; they show nothing about touch.
"""

from __future__ import annotations

from collections.abc import Callable

from tactogram_study.answers import Answer, Answers
from tactogram_study.designs import find_design
from tactogram_study.session.progress import answer_rows, next_page
from tactogram_study.session.store import SessionStore
from tactogram_study.simulated_observer import SimulatedEffect, SimulatedObserver
from tactogram_study.study_file import Study
from tactogram_study.trials import Page, PageAnswers, PageQuestion, Participant
from tactogram_study.wording import Language

Play = Callable[[Participant, Page], None]


class SimulatedParticipant(SimulatedObserver):
    """Simulated participant, who answers the pages of any design."""

    def answer(self, page: Page) -> dict[str, str]:
        """Return an answer to each question of a page, by key."""
        return {question.key: self._answer(page, question) for question in page.questions}

    def _answer(self, page: Page, question: PageQuestion) -> str:
        if page.kind == "consent":
            return "agreed"
        if page.kind == "questions":
            return self.questionnaire(question)
        return find_design(page.kind).simulated_answer(page, question, self)


def simulate(
    store: SessionStore,
    count: int,
    *,
    effect: SimulatedEffect | None = None,
    seed: int = 0,
    play: Play | None = None,
    most_pages: int | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> list[Participant]:
    """Let simulated participants take a study, one after the other, and return them.

    ``play`` is called with participant and page before each answer, to log the playback; after ``most_pages`` pages
    they stop, as if they had left; ``progress`` is called with the number of participants done.
    """
    who = []
    for done in range(1, count + 1):
        language: Language = store.study.languages[(done - 1) % len(store.study.languages)]
        participant = store.enrol(language=language, simulated=True)
        take(
            store,
            participant,
            SimulatedParticipant(effect or SimulatedEffect(), (seed, participant.number)),
            play=play,
            most_pages=most_pages,
        )
        who.append(participant)
        progress(done)
    return who


def take(
    store: SessionStore,
    participant: Participant,
    simulated: SimulatedParticipant,
    *,
    play: Play | None = None,
    most_pages: int | None = None,
) -> int:
    """Let a simulated participant take the study, or ``most_pages`` of it; return the number of pages answered."""
    pages = 0
    page = store.page(participant.code)
    while page is not None and (most_pages is None or pages < most_pages):
        if play is not None:
            play(participant, page)
        rt_ms = 1000 * simulated.seconds(page)
        page = store.submit(
            participant.code, page.token, simulated.answer(page), rt_ms={"": round(rt_ms)}
        ).page
        pages += 1
    return pages


def simulated_answers(
    study: Study, count: int, *, effect: SimulatedEffect | None = None, seed: int = 0
) -> Answers:
    """Return the answers of simulated participants as `simulate` stores them, without a session.

    Times, codes and playback are missing. For hundreds of studies.
    """
    rows: list[Answer] = []
    for number in range(1, count + 1):
        language = study.languages[(number - 1) % len(study.languages)]
        participant = Participant(f"S{number:03d}", number, language, True)
        simulated = SimulatedParticipant(effect or SimulatedEffect(), (seed, number))
        history: list[PageAnswers] = []
        while (page := next_page(study, participant, history)) is not None:
            simulated.seconds(page)  # drawn as in a session, so that the answers are the same
            responses = page.accepted(simulated.answer(page))
            rows += answer_rows(study, participant, page, responses, at="")
            history.append(PageAnswers(page.token, responses, page.more))
    return Answers(tuple(rows))
