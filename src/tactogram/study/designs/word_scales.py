"""The ten words, each on a scale, for one stimulus at a time: 7-point ratings, and evoked or not evoked.

[1] "Conditional Generative Adversarial Network-Based Tactile Stimulus Generation for Ultrasonic Tactile Display"
(Sec. III-A and V-A); [2] "A Cross-Modal Tactile Reproduction …" (Sec. II-B and II-D).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from pydantic import Field, field_validator

from tactogram.datasets.ratings.words import JAPANESE, WORDS
from tactogram.study.designs.design import Design
from tactogram.study.orders import generator, ordered
from tactogram.study.stimuli import Stimulus
from tactogram.study.trials import (
    DesignContext,
    Page,
    PageAnswers,
    PageQuestion,
    Participant,
    PresentedStimulus,
)
from tactogram.study.wording import Wording


class WordScales(Design):
    """What ratings and evoked words share."""

    kind: str
    words: tuple[str, ...] = WORDS
    """What is asked (Table 1 of [1] and [2])."""
    word_texts: dict[str, Wording] = Field(default_factory=dict)
    """How a word is shown; the ten words are known in both languages."""
    word_order: Literal["random", "as-listed"] = "random"
    """Within a page. The papers only say that what is evaluated came in random order."""
    repeats: int = Field(default=1, ge=1, le=1000)

    @field_validator("words")
    @classmethod
    def _different(cls, words: tuple[str, ...]) -> tuple[str, ...]:
        if not words or len(set(words)) != len(words):
            raise ValueError("words must differ, and there must be one at least")
        return words

    def _stimuli(self, setting: DesignContext, participant: Participant) -> Sequence[Stimulus]:
        """Return what this participant meets."""
        return setting.stimuli

    def total(self, setting: DesignContext) -> int:
        """Return the trials of the first participant."""
        return self.repeats * len(self._stimuli(setting, Participant("", 1)))

    def next_page(
        self, setting: DesignContext, participant: Participant, given: Sequence[PageAnswers]
    ) -> Page | None:
        """Return the page of the next stimulus, all words on it."""
        stimuli = self._stimuli(setting, participant)
        if len(given) == self.repeats * len(stimuli):
            return None
        order = ordered(
            range(len(stimuli)),
            rule=setting.order,
            repeats=self.repeats,
            seed=setting.seed,
            participant=participant.number,
        )
        trial = len(given) + 1
        block, repeat, which = order[trial - 1]
        stimulus = stimuli[which]
        words = list(self.words)
        if self.word_order == "random":
            drawn = generator(setting.seed, participant.number, "words", trial).permutation(len(words))
            words = [words[i] for i in drawn]
        return Page(
            token=f"trial-{trial}.1",
            kind=self.kind,
            trial=trial,
            block=block,
            repeat=repeat,
            total=len(order),
            presented=(PresentedStimulus("", stimulus),),
            text=self.instructions,
            asked=tuple(self._asked(word, stimulus) for word in words),
            layout=self._layout(),
        )

    def _word_text(self, word: str) -> Wording:
        return self.word_texts.get(word) or Wording(ja=JAPANESE.get(word, word), en=word)

    def _layout(self) -> dict[str, Any]:
        return {}

    def _asked(self, word: str, stimulus: Stimulus) -> PageQuestion:
        raise NotImplementedError
