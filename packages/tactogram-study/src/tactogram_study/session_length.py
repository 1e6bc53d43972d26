"""Planned length of a participant's session, from the pages of the first trial.

The seconds of each step are this project's assumption; a pilot measures them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from tactogram_study.questions import Question
from tactogram_study.study_file import Study
from tactogram_study.trials import Page, PageAnswers, Participant

INTRODUCTION_S = 120.0
"""Consent, and matching the card to the screen."""
ANSWER_S = {"choice": 3.0, "steps": 4.0, "vas": 6.0, "number": 6.0, "text": 20.0}
"""For each question, by its kind."""
STIMULUS_S = 3.0
"""For each stimulus whose ``seconds`` are not in the file."""
CHANGE_S = 2.0
"""Before each page, and before each stimulus."""


def planned_minutes(study: Study) -> float:
    """Return the length of a session in minutes, without rests; of a staircase with all of its trials."""
    trial = sum(map(_page_seconds, _first_trial(study)))
    trials = study.trials + (study.practice.trials if study.practice else 0)
    around = _answer_seconds((*study.before, *study.after))
    return (INTRODUCTION_S + around + trials * trial) / 60


def _first_trial(study: Study) -> Iterator[Page]:
    """Yield the pages of the first participant's first trial."""
    history: list[PageAnswers] = []
    while (page := study.design.next_page(study.setting, Participant("P1", 1), history)) is not None:
        if page.trial > 1:
            return
        yield page
        answers = {question.key: question.right or question.question.example for question in page.questions}
        history.append(PageAnswers(page.token, answers, page.more))


def _page_seconds(page: Page) -> float:
    stimuli = [one.stimulus.seconds if one.stimulus else None for one in page.presented]
    felt = sum(CHANGE_S + (seconds or STIMULUS_S) for seconds in stimuli)
    return CHANGE_S + felt + _answer_seconds([question.question for question in page.questions])


def _answer_seconds(questions: Sequence[Question]) -> float:
    return sum(ANSWER_S[question.kind] for question in questions)
