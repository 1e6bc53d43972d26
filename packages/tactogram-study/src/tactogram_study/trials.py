"""Trials, their order, pages and answers: the values that designs, store and pages exchange.

Orders are random, counterbalanced over participants, or randomised in blocks. They follow from the study's seed and the
participant's number, so that a session can be replayed.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, Literal, TypeVar

import numpy as np

from tactogram.errors import ParameterError
from tactogram_study.questions import Question
from tactogram_study.stimuli import Stimulus
from tactogram_study.wording import Language, Wording

Slot = Literal["", "A", "B", "X"]
NOTHING = Wording()
T = TypeVar("T")
Rule = Literal["random", "blocks", "latin", "williams", "as-listed"]


def generator(seed: int, participant: int, purpose: str, *more: int) -> np.random.Generator:
    """Return the generator of one purpose for one participant; other purposes never change its draws."""
    return np.random.default_rng([seed, participant, zlib.crc32(purpose.encode()), *more])


def latin_square(n: int) -> np.ndarray:
    """Return the cyclic Latin square: int64 array, shape (row, place), each of 0 … n-1 once per row and column."""
    return (np.arange(n)[:, None] + np.arange(n)) % n


def williams_square(n: int) -> np.ndarray:
    """Return a Williams design: int64 array, shape (row, place).

    Latin, and each follows each other equally often: once over ``n`` rows for an even ``n``, twice over ``2 n`` rows
    for an odd one. After E. J. Williams, "Experimental designs balanced for the estimation of residual effects of
    treatments", Aust. J. Sci. Res. A 2, 149-168 (1949).
    """
    zigzag = np.array([(index + 1) // 2 if index % 2 else -(index // 2) for index in range(n)])
    square = (zigzag + np.arange(n)[:, None]) % n
    return square if n % 2 == 0 or n == 1 else np.concatenate([square, square[:, ::-1]])


def ordered(
    items: Sequence[T], *, rule: Rule, repeats: int, seed: int, participant: int
) -> tuple[tuple[int, int, T], ...]:
    """Return (block, repeat, item) of each trial of one participant, in order.

    - ``random``: all repeats of all items in one random order, one block.
    - ``blocks``: each repeat is a block of all items, each in its own random order.
    - ``latin``, ``williams``: each repeat is a block; its order is a row of the square, the next one for the next
      repeat and for the next participant. The numbers of the items are drawn once for the study.
    - ``as-listed``: block by block in the given order.
    """
    if not items:
        raise ParameterError("an order needs at least 1 item, got 0")
    return tuple(
        (block, repeat, items[i])
        for block, repeat, i in _places(len(items), rule, repeats, seed, participant)
    )


@lru_cache(maxsize=256)  # requested at every page, and the same for all pages of a participant
def _places(
    count: int, rule: Rule, repeats: int, seed: int, participant: int
) -> tuple[tuple[int, int, int], ...]:
    if rule == "random":
        listed = [(repeat, i) for repeat in range(1, repeats + 1) for i in range(count)]
        drawn = generator(seed, participant, "order").permutation(len(listed))
        return tuple((1, *listed[index]) for index in drawn)
    return tuple(
        (repeat, repeat, i)
        for repeat in range(1, repeats + 1)
        for i in _block(rule, count, repeat, repeats, seed, participant)
    )


def _block(rule: Rule, count: int, repeat: int, repeats: int, seed: int, participant: int) -> list[int]:
    if rule == "as-listed":
        return list(range(count))
    if rule == "blocks":
        return [int(i) for i in generator(seed, participant, "order", repeat).permutation(count)]
    square = latin_square(count) if rule == "latin" else williams_square(count)
    row = ((participant - 1) * repeats + repeat - 1) % len(square)
    # One relabelling for all participants: another for each would destroy the balance.
    labels = generator(seed, 0, "order").permutation(count)
    return [int(i) for i in labels[square[row]]]


def balanced_sides(count: int, rng: np.random.Generator, sides: Sequence[str] = ("A", "B")) -> list[str]:
    """Return ``count`` sides in random order, each equally often; the remainder is drawn."""
    rounds = [side for _ in range(count // len(sides)) for side in sides]
    rest = rng.permutation(len(sides))[: count % len(sides)]
    listed = rounds + [sides[i] for i in rest]
    return [listed[i] for i in rng.permutation(count)]


@dataclass(frozen=True)
class Participant:
    """Participant of a study: a code of letters and digits, never a name, and a number for the counterbalancing.

    ``number`` counts from 1 in the order of enrolment; ``session`` names the sitting, which is ``active`` unless the
    experimenter ended it.
    """

    code: str
    number: int
    language: Language = "en"
    simulated: bool = False
    session: str = "1"
    active: bool = True


@dataclass(frozen=True)
class DesignContext:
    """The part of a study that its design needs; ``names`` of items and conditions where they are not their keys."""

    name: str
    seed: int
    order: Rule
    stimuli: tuple[Stimulus, ...]
    names: Mapping[str, Wording] = field(default_factory=dict)

    def stimulus(self, name: str) -> Stimulus | None:
        """Return the stimulus of a name, None if there is none."""
        return next((stimulus for stimulus in self.stimuli if stimulus.name == name), None)

    def ordered(
        self, items: Sequence[T], participant: Participant, *, repeats: int
    ) -> tuple[tuple[int, int, T], ...]:
        """Return (block, repeat, item) of each of a participant's trials, by the study's order."""
        return ordered(
            items, rule=self.order, repeats=repeats, seed=self.seed, participant=participant.number
        )


@dataclass(frozen=True)
class PresentedStimulus:
    """A stimulus in a slot of a page, played ``gain_db`` stronger than its level; None is silence."""

    slot: Slot
    stimulus: Stimulus | None
    gain_db: float = 0.0


@dataclass(frozen=True)
class PageQuestion:
    """A question on a page, and what the answer will mean; participants see the question alone.

    ``slot`` is that of the stimulus in question, where the page asks about each; ``side`` is that of the target;
    ``right`` is the correct answer, if any; ``values`` are the ``value`` of each answer, by default the number that it
    is. The other members are columns of `tactogram_study.answers`.
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
        Unique within the participant's session; answers are stored once per token.
    kind : str
        ``consent``, ``questions``, or the design's.
    questions : tuple of PageQuestion
    presented : tuple of PresentedStimulus
    text : Wording
        Instructions.
    trial, step, block, repeat : int
        From 1. A trial can have several pages, its steps.
    total : int
        Number of trials, or the largest possible; 0 outside trials.
    rest : bool
        Whether a rest is offered before it.
    practice : bool
        Whether its answers do not count.
    more : mapping from str to str
        Extra columns of its answers.
    layout : mapping from str to JSON values
        Sizes in mm, speeds in mm/s; texts are Wordings.
    """

    token: str
    kind: str
    questions: tuple[PageQuestion, ...]
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
        """Return the valid answers by key; raise `ParameterError` if one is missing, invalid or unknown."""
        keys = [question.key for question in self.questions]
        if unknown := sorted(set(responses) - set(keys)):
            raise ParameterError(
                f"page {self.token} asks {', '.join(keys)}, got an answer to {unknown[0][:60]!r}"
            )
        return {asked.key: asked.question.accepted(responses.get(asked.key, "")) for asked in self.questions}

    def slot(self, name: str) -> PresentedStimulus:
        """Return the stimulus of a slot; raise `ParameterError` if the page has no such slot."""
        for presented in self.presented:
            if presented.slot == name:
                return presented
        slots = ", ".join(repr(presented.slot) for presented in self.presented) or "none"
        raise ParameterError(f"page {self.token} has the slots {slots}, got {name[:20]!r}")

    def shown(self, language: Language) -> dict[str, Any]:
        """Return what a participant may see, as JSON values: no stimulus names, no conditions, no right answers."""
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
            "questions": [_question_shown(question, language) for question in self.questions],
        }


@dataclass(frozen=True)
class PageAnswers:
    """Accepted answers to a page by key; ``facts`` are its ``more``, so that nothing presented is computed again."""

    token: str
    responses: Mapping[str, str]
    facts: Mapping[str, str] = field(default_factory=dict)


History = Sequence[PageAnswers]
"""Answered pages of a participant, in order."""


def _in_language(value: Any, language: Language) -> Any:
    if isinstance(value, Wording):
        return value.in_language(language)
    if isinstance(value, Mapping):
        return {name: _in_language(inner, language) for name, inner in value.items()}
    return value


def _slot_shown(presented: PresentedStimulus, language: Language) -> dict[str, Any]:
    stimulus = presented.stimulus
    return {
        "slot": presented.slot,
        # Silence counts as played: a participant who saw the difference would not need to feel it.
        "played": stimulus is None or stimulus.is_played,
        "picture": stimulus is not None and stimulus.is_seen,
        "text": stimulus.text.in_language(language) if stimulus is not None else "",
    }


def _question_shown(page_question: PageQuestion, language: Language) -> dict[str, Any]:
    question = page_question.question
    return {
        "key": page_question.key,
        "slot": page_question.slot,
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
