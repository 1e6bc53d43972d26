"""Trials, pages and answers: the values that designs, store and pages exchange."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from tactogram.errors import ParameterError
from tactogram.study.orders import Rule
from tactogram.study.questions import Question
from tactogram.study.stimuli import Stimulus
from tactogram.study.wording import Language, Wording

Slot = Literal["", "A", "B", "X"]
NOTHING = Wording()


@dataclass(frozen=True)
class Participant:
    """Participant of a study: a code, and a number that the counterbalancing follows.

    Parameters
    ----------
    code : str
        Letters and digits; never a name.
    number : int
        From 1, in the order of enrolment.
    language : {"ja", "en"}
    simulated : bool
        Whether a program answers.
    session : str
        What the sitting is called.
    """

    code: str
    number: int
    language: Language = "en"
    simulated: bool = False
    session: str = "1"


@dataclass(frozen=True)
class DesignContext:
    """Facts of the study that a design needs.

    Parameters
    ----------
    name : str
    seed : int
    order : Rule
    stimuli : tuple of Stimulus
    names : mapping from str to Wording
        What items and conditions are called, where not by their keys.
    """

    name: str
    seed: int
    order: Rule
    stimuli: tuple[Stimulus, ...]
    names: Mapping[str, Wording] = field(default_factory=dict)


@dataclass(frozen=True)
class PresentedStimulus:
    """A stimulus on a page.

    Parameters
    ----------
    slot : {"", "A", "B", "X"}
        What the participant knows it as.
    stimulus : Stimulus or None
        None is silence.
    gain_db : float
        By how much it is played stronger than its level says.
    """

    slot: Slot
    stimulus: Stimulus | None
    gain_db: float = 0.0


@dataclass(frozen=True)
class PageQuestion:
    """A question on a page, with what the answer will mean; nothing of that is shown.

    Parameters
    ----------
    question : Question
    slot : str
        Which stimulus it is about, where the page asks about each.
    side : str
        Where the asked-for stimulus is.
    right : str
        The correct answer, "" if none is.
    stimulus, condition, other, other_condition : str
        See `tactogram.study.answers`.
    values : mapping from str to float
        What ``value`` becomes for an answer; else the number that it is.
    """

    question: Question
    slot: Slot = ""
    side: str = ""
    right: str = ""
    stimulus: str = ""
    condition: str = ""
    other: str = ""
    other_condition: str = ""
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def key(self) -> str:
        """Its name on the page."""
        return f"{self.question.id}:{self.slot}" if self.slot else self.question.id


@dataclass(frozen=True)
class Page:
    """Page that is shown until it is answered.

    Parameters
    ----------
    token : str
        Its own within the participant's session; an answer is stored once per token.
    kind : str
        ``consent``, ``questions``, or the design's.
    asked : tuple of Asked
    presented : tuple of Presented
    text : Wording
        What to do.
    trial, step, block, repeat : int
        From 1. A trial can have several pages, its steps.
    total : int
        Trials there are, or at most will be; 0 where it is no trial.
    rest : bool
        Whether a rest is offered before it.
    practice : bool
        Whether its answers do not count.
    more : mapping from str to str
        Further columns of its answers.
    layout : mapping from str to JSON values
        What the design says of how it looks: sizes in mm, speeds in mm/s; texts are Wordings.
    """

    token: str
    kind: str
    asked: tuple[PageQuestion, ...]
    presented: tuple[PresentedStimulus, ...] = ()
    text: Wording = NOTHING
    trial: int = 1
    step: int = 1
    block: int = 1
    repeat: int = 1
    total: int = 0
    rest: bool = False
    practice: bool = False
    more: Mapping[str, str] = field(default_factory=dict)
    layout: Mapping[str, Any] = field(default_factory=dict)

    def accepted(self, responses: Mapping[str, str]) -> dict[str, str]:
        """Return the answers to its questions, by key.

        Raises
        ------
        ParameterError
            If one is missing, not an answer, or to no question of this page.
        """
        if unknown := sorted(set(responses) - {asked.key for asked in self.asked}):
            known = ", ".join(asked.key for asked in self.asked)
            raise ParameterError(f"page {self.token} asks {known}, got an answer to {unknown[0][:60]!r}")
        return {asked.key: asked.question.accepted(responses.get(asked.key, "")) for asked in self.asked}

    def slot(self, name: str) -> PresentedStimulus:
        """Return what is in a slot.

        Raises
        ------
        ParameterError
            If the page has no such slot.
        """
        for presented in self.presented:
            if presented.slot == name:
                return presented
        slots = ", ".join(repr(presented.slot) for presented in self.presented) or "none"
        raise ParameterError(f"page {self.token} has the slots {slots}, got {name[:20]!r}")

    def shown(self, language: Language) -> dict[str, Any]:
        """Return what a participant may know, as JSON values: no names of stimuli, no conditions, no right answers."""
        return {
            "token": self.token,
            "kind": self.kind,
            "text": self.text.in_language(language),
            "trial": self.trial,
            "step": self.step,
            "total": self.total,
            "rest": self.rest,
            "layout": _in_language(self.layout, language),
            "slots": [_slot_shown(presented, language) for presented in self.presented],
            "questions": [_question_shown(asked, language) for asked in self.asked],
        }


@dataclass(frozen=True)
class PageAnswers:
    """Answers to a page.

    Parameters
    ----------
    token : str
    responses : mapping from str to str
        Accepted answers by key.
    facts : mapping from str to str
        ``more`` of the page: what was shown does not depend on computing it again.
    """

    token: str
    responses: Mapping[str, str]
    facts: Mapping[str, str] = field(default_factory=dict)


def _in_language(value: Any, language: Language) -> Any:
    if isinstance(value, Wording):
        return value.in_language(language)
    if isinstance(value, Mapping):
        return {name: _in_language(inner, language) for name, inner in value.items()}
    return value


def _slot_shown(presented: PresentedStimulus, language: Language) -> dict[str, Any]:
    stimulus = presented.stimulus
    picture = stimulus is not None and stimulus.is_seen
    # Silence is announced as played: who could see the difference need not feel it.
    played = stimulus is None or stimulus.is_played
    text = stimulus.text.in_language(language) if stimulus is not None else ""
    return {"slot": presented.slot, "played": played, "picture": picture, "text": text}


def _question_shown(asked: PageQuestion, language: Language) -> dict[str, Any]:
    question = asked.question
    return {
        "key": asked.key,
        "slot": asked.slot,
        "text": question.text.in_language(language),
        "kind": question.kind,
        "options": [
            {"value": option.value, "text": option.text.in_language(language)} for option in question.options
        ],
        "low": None if question.low != question.low else question.low,
        "high": None if question.high != question.high else question.high,
        "low_text": question.low_text.in_language(language),
        "high_text": question.high_text.in_language(language),
        "required": question.required,
    }
