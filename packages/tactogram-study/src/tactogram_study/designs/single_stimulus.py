"""Bases of designs that ask about one stimulus at a time, each equally often, in the study's order.

[1] "Conditional Generative Adversarial Network-Based Tactile Stimulus Generation for Ultrasonic Tactile Display"
(Sec. III-A and V-A); [2] "A Cross-Modal Tactile Reproduction …" (Sec. II-B and II-D).
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal

from pydantic import Field, field_validator

from tactogram_study.designs.design import Design
from tactogram_study.questions import IDENTIFIER
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, History, Page, PageQuestion, Participant, generator
from tactogram_study.wording import Wording, default_text, language_texts


class SingleStimulus(Design):
    """A design with a page per stimulus; a subclass defines its questions in `questions_about`."""

    repeats: int = Field(default=1, ge=1, le=1000, title="Repeats of each stimulus")
    """Trials of each stimulus."""

    @abstractmethod
    def questions_about(
        self, stimulus: Stimulus, *, setting: DesignContext, participant: Participant, trial: int
    ) -> tuple[PageQuestion, ...]:
        """Return the questions of a trial."""

    def stimuli_of(self, setting: DesignContext, participant: Participant) -> Sequence[Stimulus]:
        """Return a participant's stimuli; all by default."""
        return setting.stimuli

    def layout(self) -> dict[str, Any]:
        """Return the layout of its pages."""
        return {}

    def total(self, setting: DesignContext) -> int:
        """Return the trials of the first participant."""
        return self.repeats * len(self.stimuli_of(setting, Participant("", 1)))

    def next_page(self, setting: DesignContext, participant: Participant, history: History) -> Page | None:
        stimuli = self.stimuli_of(setting, participant)
        if len(history) == self.repeats * len(stimuli):
            return None
        order = setting.ordered(range(len(stimuli)), participant, repeats=self.repeats)
        trial = len(history) + 1
        block, repeat, which = order[trial - 1]
        stimulus = stimuli[which]
        questions = self.questions_about(stimulus, setting=setting, participant=participant, trial=trial)
        return self.trial_page(
            trial,
            questions,
            {"": stimulus},
            block=block,
            repeat=repeat,
            total=len(order),
            layout=self.layout(),
        )


def _ten_words() -> tuple[str, ...]:
    from tactogram.datasets import WORDS  # imports libraries that listing designs does not need

    return WORDS


class WordScales(SingleStimulus):
    """A design that asks about each of several words."""

    labels: ClassVar[Mapping[str, str]] = {
        "word_order.random": "random",
        "word_order.as-listed": "as listed",
    }

    words: tuple[str, ...] = Field(default_factory=_ten_words)
    """Words in question (Table 1 of [1] and [2])."""
    word_texts: dict[str, Wording] = Field(default_factory=dict)
    """Texts of the words; the ten words have texts in every language, others are their own text."""
    word_order: Literal["random", "as-listed"] = Field(default="random", title="Order of the words on a page")
    """Within a page. The papers only state a random order of what was evaluated."""

    @field_validator("words")
    @classmethod
    def _different(cls, words: tuple[str, ...]) -> tuple[str, ...]:
        if not words or len(set(words)) != len(words):
            raise ValueError("words must be distinct, and at least one")
        for word in words:
            if not re.fullmatch(IDENTIFIER, word):
                raise ValueError(
                    "a word must be letters, digits, _ and -, beginning with a letter; give its text in word_texts"
                )
        return words

    def questions_about(
        self, stimulus: Stimulus, *, setting: DesignContext, participant: Participant, trial: int
    ) -> tuple[PageQuestion, ...]:
        words = list(self.words)
        if self.word_order == "random":
            drawn = generator(setting.seed, participant.number, "words", trial).permutation(len(words))
            words = [words[i] for i in drawn]
        return tuple(self.word_question(word, stimulus) for word in words)

    @abstractmethod
    def word_question(self, word: str, stimulus: Stimulus) -> PageQuestion:
        """Return the question about one word."""

    def word_text(self, word: str) -> Wording:
        """Return the text of a word."""
        if text := self.word_texts.get(word):
            return text
        return default_text(key) if (key := f"word_{word}") in language_texts()["en"] else Wording(word)
