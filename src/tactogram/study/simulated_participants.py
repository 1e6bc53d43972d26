"""Simulated participants: programs that take a study as people do, with an effect that was put in, or none.

They answer through the same interface as the participant pages, and every row of theirs says that it is simulated. They
test the pages, the store and the analysis; they say nothing about touch.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

import numpy as np
from pydantic import BaseModel, ConfigDict, Field
from scipy.special import ndtr

from tactogram.study.answers import Answer, Answers
from tactogram.study.designs import find_design
from tactogram.study.session.sitting import answer_rows, next_page
from tactogram.study.session.store import SessionStore
from tactogram.study.study_file import Study
from tactogram.study.trials import Page, PageAnswers, PageQuestion, Participant
from tactogram.study.wording import Language

Play = Callable[[Participant, Page], None]


class SimulatedEffect(BaseModel):
    """True effect in simulated participants. The defaults put no effect in."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    d_prime: float = Field(default=0.0, ge=0, le=10)
    """How well two stimuli are distinguished, in sds."""
    d_prime_sd: float = Field(default=0.0, ge=0, le=10)
    """Between participants; a negative one counts as 0."""
    shift: dict[str, float] = Field(default_factory=dict)
    """By how much a condition, or an item, is answered higher: mm on a VAS, steps on a scale, logits of a yes or of
    being preferred, factors of 10 of a number; of a threshold dB."""
    typical_sd: float = Field(default=1.0, ge=0)
    """Between items, in what a word says of each to all: 1 is 0.15 of a scale's width, and a logit of evoking. With 0
    all items are alike but for ``shift``."""
    between_sd: float = Field(default=1.0, ge=0)
    """Between participants, in units of ``unit``: VAS and ratings as a whole."""
    within_sd: float = Field(default=1.0, ge=0)
    """From answer to answer of the same participant, in units of ``unit``."""
    exponent: float = Field(default=0.0, ge=-5, le=5)
    """Of the power law from intensity to magnitude, where levels are ``gain=`` or ``peak=``."""
    exponent_sd: float = Field(default=0.0, ge=0, le=5)
    """Between participants. No figure of it was found for vibration that is made: 0 unless a pilot says otherwise."""
    preference_sd: float = Field(default=0.0, ge=0, le=10)
    """Between participants, in how much each of them prefers each item: logits. Likewise 0."""
    threshold_db: float = Field(default=-20.0, allow_inf_nan=False)
    """Intensity at which half of the way from guessing to certainty is gone."""
    threshold_sd_db: float = Field(default=3.0, ge=0)
    """Between participants."""
    spread_db: float = Field(default=4.0, gt=0)
    """Sd of the cumulative normal that leads from guessing to certainty."""
    lapse: float = Field(default=0.02, ge=0, le=0.5)
    """Share of answers that are wrong however strong it is."""


UNIT: Mapping[str, float] = {"vas": 10.0, "steps": 1.0, "number": 0.1}
"""What 1 stands for in ``between_sd`` and ``within_sd``: mm, steps, factors of 10."""
AVERAGE_SHARE = 0.55
"""Of a VAS: the paper's realism lay between 50 and 60 mm for most textures (Saga et al., Sec. IV-B)."""


class SimulatedParticipant:
    """One of them.

    Parameters
    ----------
    effect : SimulatedEffect
    seed : sequence of int
        Its own; the same gives the same answers to the same pages.
    """

    def __init__(self, effect: SimulatedEffect, seed: Sequence[int]) -> None:
        self.effect = effect
        self.rng = np.random.default_rng([*seed, 0])
        self.truth = int(seed[0])
        self.d_prime = max(0.0, effect.d_prime + effect.d_prime_sd * self.rng.standard_normal())
        self.threshold_db = effect.threshold_db + effect.threshold_sd_db * self.rng.standard_normal()
        self.bias = effect.between_sd * self.rng.standard_normal()
        self.seed = tuple(seed)
        self.exponent = effect.exponent + effect.exponent_sd * _own(self.seed, "exponent")

    def answer(self, page: Page) -> dict[str, str]:
        """Return an answer to each question of a page, by key."""
        return {asked.key: self._answer(page, asked) for asked in page.asked}

    def seconds(self, page: Page) -> float:
        """Return how long a page took, s: lognormal about 2 s for each question."""
        return float(len(page.asked) * 2.0 * math.exp(0.4 * self.rng.standard_normal()))

    def right_or_wrong(self, asked: PageQuestion, share: float) -> str:
        """Return the right answer in a share of trials, else another."""
        return asked.right if self.rng.random() < share else self.other_option(asked, asked.right)

    def other_option(self, asked: PageQuestion, but: str) -> str:
        """Return another option of a question: where there are several, one of them at random."""
        others = [option.value for option in asked.question.options if option.value != but]
        return others[self.rng.integers(len(others))] if len(others) > 1 else others[0]

    def choice(self, asked: PageQuestion) -> str:
        """Return an option: of two with different values the higher by its logit for this item, else any of them."""
        options = [option.value for option in asked.question.options]
        values = [asked.values.get(option, math.nan) for option in options]
        if len(options) != 2 or not abs(values[0] - values[1]) > 0:  # nor where one has no value
            return options[self.rng.integers(len(options))]
        high = options[int(values[1] > values[0])]
        likely = self.yes(self.typical(asked) + self.shift(asked) + self.bias / 2)
        return high if likely else self.other_option(asked, high)

    def yes(self, logit: float) -> bool:
        """Return whether a yes, of that logit, is said."""
        return bool(self.rng.random() < 1 / (1 + math.exp(-logit)))

    def two_alternatives(self) -> float:
        """Return the share correct of two alternatives."""
        return float(ndtr(self.d_prime / math.sqrt(2)))

    def number(self, asked: PageQuestion, more: float = 0.0) -> str:
        """Return a number around 10, with what is typical of the participant; ``more`` are further factors of 10."""
        noise = self.effect.within_sd * self.rng.standard_normal()
        told = 1.0 + self.shift(asked) + more + UNIT["number"] * (self.bias + noise)
        return f"{_within(10**told, asked):.4g}"

    def on_scale(self, asked: PageQuestion) -> str:
        """Return a place on a line, a step, or a number, with the item's own, the effect, the bias and the noise."""
        question = asked.question
        if question.kind == "number":
            return self.number(asked)
        noise = self.effect.within_sd * self.rng.standard_normal()
        width = question.high - question.low
        share = AVERAGE_SHARE if question.kind == "vas" else 0.5 + 0.15 * self.typical(asked)
        value = question.low + width * share + self.shift(asked) + UNIT[question.kind] * (self.bias + noise)
        value = _within(value, asked)
        return f"{value:.0f}" if question.kind == "steps" else f"{value:.1f}"

    def shift(self, asked: PageQuestion) -> float:
        """Return the effect that was put in for the item and the condition of a question."""
        return self._shift_of(asked.stimulus, asked.condition)

    def typical(self, asked: PageQuestion) -> float:
        """Return what a question's word says of its item to all participants, sds."""
        return typical(self.effect, self.truth, asked.stimulus, asked.question.id)

    def strength(self, item: str, condition: str) -> float:
        """Return how much this participant prefers an item, logits: what is true of all, and what is of this one."""
        own = self.effect.preference_sd * _own(self.seed, "preference", item, condition)
        return self._shift_of(item, condition) + own

    def _answer(self, page: Page, asked: PageQuestion) -> str:
        if page.kind == "consent":
            return "agreed"
        if page.kind == "questions":
            return self._questionnaire(asked)
        return find_design(page.kind).simulated_answer(page, asked, self)

    def _shift_of(self, item: str, condition: str) -> float:
        shift = self.effect.shift
        return shift.get(item, 0.0) + (shift.get(condition, 0.0) if condition != item else 0.0)

    def _questionnaire(self, asked: PageQuestion) -> str:
        question = asked.question
        if question.kind == "choice":
            return self.choice(asked)
        if question.kind == "text":
            return "(simulated)"
        low = question.low if math.isfinite(question.low) else 20
        high = question.high if math.isfinite(question.high) else max(low, 60)
        return str(int(self.rng.integers(math.ceil(low), math.floor(high) + 1)))


def _within(value: float, asked: PageQuestion) -> float:
    """Return a value held at the ends of a question's scale, where it has any."""
    low, high = asked.question.low, asked.question.high
    value = value if math.isnan(high) else min(value, high)
    return value if math.isnan(low) else max(value, low)


@lru_cache(maxsize=4096)
def _own(seed: tuple[int, ...], *what: str) -> float:
    """Return a standard normal number that is always the same of one participant and matter.

    Not of the participant's generator: answers to all else are the same whether or not people differ in this.
    """
    return float(np.random.default_rng([*seed, 1, *"\0".join(what).encode()]).standard_normal())


def typical(effect: SimulatedEffect, seed: int, item: str, word: str) -> float:
    """Return what a word says of an item to all: drawn, the same for every participant and condition."""
    drawn = np.random.default_rng([seed, *f"{item}\0{word}".encode()]).standard_normal()
    return effect.typical_sd * float(drawn)


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

    Parameters
    ----------
    store : SessionStore
    count : int
    effect : SimulatedEffect, optional
        By default none.
    seed : int
        Of their answers.
    play : callable, optional
        Called with participant and page before each is answered, to log what is played.
    most_pages : int, optional
        They stop after so many pages, as if they had left.
    progress : callable, optional
        Called with how many are done.
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
    """Let one take the study to its end, or ``most_pages`` of it; return how many pages were answered."""
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
    """Return the answers of simulated participants, without a session: those that `simulate` would have stored.

    But for times, codes and what was played, which are not there: for studies by the hundred.

    Parameters
    ----------
    study : Study
    count : int
        Participants, numbered from 1.
    effect : SimulatedEffect, optional
        By default none.
    seed : int
        Of their answers.
    """
    rows: list[Answer] = []
    for number in range(1, count + 1):
        language = study.languages[(number - 1) % len(study.languages)]
        participant = Participant(f"S{number:03d}", number, language, True)
        one = SimulatedParticipant(effect or SimulatedEffect(), (seed, number))
        given: list[PageAnswers] = []
        while (page := next_page(study, participant, given)) is not None:
            one.seconds(page)  # drawn where a session draws it, so that the answers are the same
            responses = page.accepted(one.answer(page))
            rows += answer_rows(study, participant, page, responses, at="")
            given.append(PageAnswers(page.token, responses, page.more))
    return Answers(tuple(rows))
