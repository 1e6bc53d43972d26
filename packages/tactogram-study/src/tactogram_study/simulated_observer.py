"""Simulated observer: what a simulated participant feels, with or without a true effect."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache

import numpy as np
from pydantic import Field
from scipy.special import ndtr

from tactogram.validation import FrozenModel
from tactogram_study.questions import Question
from tactogram_study.trials import Page, PageQuestion


class SimulatedEffect(FrozenModel):
    """True effect in simulated participants; none by default."""

    d_prime: float = Field(default=0.0, ge=0, le=10)
    """Discriminability of two stimuli, in sds."""
    d_prime_sd: float = Field(default=0.0, ge=0, le=10)
    """Sd of d' between participants; a negative d' counts as 0."""
    shift: dict[str, float] = Field(default_factory=dict)
    """Shift of the answers about a condition or an item: mm on a VAS, steps on a scale, logits of a yes or of a
    preference, factors of 10 of a number, dB of a threshold."""
    typical_sd: float = Field(default=1.0, ge=0)
    """Sd between items of a word's typical score: 1 is 0.15 of a scale's width, and a logit of evoking. With 0 all
    items are equal but for ``shift``."""
    between_sd: float = Field(default=1.0, ge=0)
    """Sd between participants of the mean VAS mark or rating, in units of `UNIT`."""
    within_sd: float = Field(default=1.0, ge=0)
    """Sd between answers of a participant, in units of `UNIT`."""
    exponent: float = Field(default=0.0, ge=-5, le=5)
    """Exponent of the power law from intensity to magnitude, where levels are ``gain=`` or ``peak=``."""
    exponent_sd: float = Field(default=0.0, ge=0, le=5)
    """Sd between participants. No published value was found for generated vibration: 0 unless a pilot has one."""
    preference_sd: float = Field(default=0.0, ge=0, le=10)
    """Sd between participants of the preference for each item, logits. Likewise 0."""
    threshold_db: float = Field(default=-20.0, allow_inf_nan=False)
    """Intensity halfway from guessing to certainty."""
    threshold_sd_db: float = Field(default=3.0, ge=0)
    """Sd between participants."""
    spread_db: float = Field(default=4.0, gt=0)
    """Sd of the cumulative normal from guessing to certainty."""
    lapse: float = Field(default=0.02, ge=0, le=0.5)
    """Share of wrong answers at any intensity."""


UNIT: Mapping[str, float] = {"vas": 10.0, "steps": 1.0, "number": 0.1}
"""Unit of ``between_sd`` and ``within_sd``: mm, steps, factors of 10."""
AVERAGE_SHARE = 0.55
"""Mean share of a VAS: the paper's realism lay between 50 and 60 mm for most textures (Saga et al., Sec. IV-B)."""


class SimulatedObserver:
    """Observer in place of a participant, simulated; the same seed gives the same answers to the same questions."""

    def __init__(self, effect: SimulatedEffect, seed: Sequence[int]) -> None:
        self.effect = effect
        self.rng = np.random.default_rng([*seed, 0])
        self.truth = int(seed[0])
        self.d_prime = max(0.0, effect.d_prime + effect.d_prime_sd * self.rng.standard_normal())
        self.threshold_db = effect.threshold_db + effect.threshold_sd_db * self.rng.standard_normal()
        self.bias = effect.between_sd * self.rng.standard_normal()
        self.seed = tuple(seed)
        self.exponent = effect.exponent + effect.exponent_sd * _personal(self.seed, "exponent")

    def seconds(self, page: Page) -> float:
        """Return the time on a page, s: lognormal, about 2 s for each question."""
        return float(len(page.questions) * 2.0 * math.exp(0.4 * self.rng.standard_normal()))

    def other_option(self, question: PageQuestion, excluded: str) -> str:
        """Return another option of a question, one at random if there are several."""
        others = [option.value for option in question.question.options if option.value != excluded]
        return others[self.rng.integers(len(others))] if len(others) > 1 else others[0]

    def choice(self, question: PageQuestion) -> str:
        """Return an option: of two with different values the higher with the item's logit, else any at random."""
        options = [option.value for option in question.question.options]
        values = [question.values.get(option, math.nan) for option in options]
        if len(options) != 2 or not abs(values[0] - values[1]) > 0:  # nor where one has no value
            return options[self.rng.integers(len(options))]
        high = options[int(values[1] > values[0])]
        chosen = self.yes(self.typical(question) + self.shift(question) + self.bias / 2)
        return high if chosen else self.other_option(question, high)

    def yes(self, logit: float) -> bool:
        """Return whether the answer is yes, at that logit."""
        return bool(self.rng.random() < 1 / (1 + math.exp(-logit)))

    def two_alternatives(self) -> float:
        """Return the share correct of two alternatives."""
        return float(ndtr(self.d_prime / math.sqrt(2)))

    def number(self, question: PageQuestion, more: float = 0.0) -> str:
        """Return a number around 10 with the participant's bias; ``more`` are further factors of 10."""
        noise = self.effect.within_sd * self.rng.standard_normal()
        exponent = 1.0 + self.shift(question) + more + UNIT["number"] * (self.bias + noise)
        return f"{_within(10**exponent, question.question):.4g}"

    def on_scale(self, page_question: PageQuestion) -> str:
        """Return a mark, a step, or a number: typical value of the item, effect, bias and noise."""
        question = page_question.question
        if question.kind == "number":
            return self.number(page_question)
        noise = self.effect.within_sd * self.rng.standard_normal()
        width = question.high - question.low
        share = AVERAGE_SHARE if question.kind == "vas" else 0.5 + 0.15 * self.typical(page_question)
        value = question.low + width * share + self.shift(page_question)
        value = _within(value + UNIT[question.kind] * (self.bias + noise), question)
        return f"{value:.0f}" if question.kind == "steps" else f"{value:.1f}"

    def shift(self, question: PageQuestion) -> float:
        """Return the true effect of a question's item and condition."""
        return self._shift_of(question.stimulus, question.condition)

    def typical(self, question: PageQuestion) -> float:
        """Return the typical score of a question's word and item over all participants, sds."""
        return typical(self.effect, self.truth, question.stimulus, question.question.id)

    def strength(self, item: str, condition: str) -> float:
        """Return the preference for an item, logits: that of all participants plus this one's."""
        personal = self.effect.preference_sd * _personal(self.seed, "preference", item, condition)
        return self._shift_of(item, condition) + personal

    def _shift_of(self, item: str, condition: str) -> float:
        shift = self.effect.shift
        return shift.get(item, 0.0) + (shift.get(condition, 0.0) if condition != item else 0.0)

    def questionnaire(self, page_question: PageQuestion) -> str:
        """Return an answer to a question before or after the trials."""
        question = page_question.question
        if question.kind == "choice":
            return self.choice(page_question)
        if question.kind == "text":
            return "(simulated)"
        low = question.low if math.isfinite(question.low) else 20
        high = question.high if math.isfinite(question.high) else max(low, 60)
        return str(int(self.rng.integers(math.ceil(low), math.floor(high) + 1)))


def _within(value: float, question: Question) -> float:
    """Return a value limited to the ends of a question's scale, if it has any."""
    value = value if math.isnan(question.high) else min(value, question.high)
    return value if math.isnan(question.low) else max(value, question.low)


@lru_cache(maxsize=4096)
def _personal(seed: tuple[int, ...], *trait: str) -> float:
    """Return a standard normal number that is fixed for a participant and a trait.

    Not from the participant's generator: other answers are the same whether or not people differ in this trait.
    """
    return float(np.random.default_rng([*seed, 1, *"\0".join(trait).encode()]).standard_normal())


def typical(effect: SimulatedEffect, seed: int, item: str, word: str) -> float:
    """Return the typical score of a word for an item: drawn, the same for every participant and condition."""
    drawn = np.random.default_rng([seed, *f"{item}\0{word}".encode()]).standard_normal()
    return effect.typical_sd * float(drawn)
