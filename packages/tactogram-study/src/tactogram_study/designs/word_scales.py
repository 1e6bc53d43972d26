"""Base of ratings and evoked words: several words about one stimulus at a time.

[1] "Conditional Generative Adversarial Network-Based Tactile Stimulus Generation for Ultrasonic Tactile Display"
(Sec. III-A and V-A); [2] "A Cross-Modal Tactile Reproduction …" (Sec. II-B and II-D).
"""

from __future__ import annotations

import re
from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar, Literal

from pydantic import Field, field_validator

from tactogram_study.designs.single_stimulus import SingleStimulus
from tactogram_study.language_files import default_text, language_texts
from tactogram_study.orders import generator
from tactogram_study.questions import IDENTIFIER
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, PageQuestion, Participant
from tactogram_study.wording import Wording


def _ten_words() -> tuple[str, ...]:
    from tactogram.datasets import WORDS  # imports libraries that listing designs does not need

    return WORDS


class WordScales(SingleStimulus):
    """A design that asks about each of several words."""

    labels: ClassVar[Mapping[str, str]] = {
        "word_order": "Order of the words on a page",
        "word_order.random": "random",
        "word_order.as-listed": "as listed",
        "repeats": "Repeats of each stimulus",
    }

    words: tuple[str, ...] = Field(default_factory=_ten_words)
    """Words in question (Table 1 of [1] and [2])."""
    word_texts: dict[str, Wording] = Field(default_factory=dict)
    """Texts of the words; the ten words have texts in every language, others are their own text."""
    word_order: Literal["random", "as-listed"] = "random"
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
