"""The ten words, each on a scale, for one stimulus at a time: 7-point ratings, and evoked or not evoked.

[1] "Conditional Generative Adversarial Network-Based Tactile Stimulus Generation for Ultrasonic Tactile Display"
(Sec. III-A and V-A); [2] "A Cross-Modal Tactile Reproduction …" (Sec. II-B and II-D).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, Self

from pydantic import Field, field_validator

from tactogram.datasets.ratings.words import JAPANESE, WORDS
from tactogram.errors import ParameterError
from tactogram.study.designs.design import Design
from tactogram.study.orders import generator, ordered
from tactogram.study.questions import Option, Question
from tactogram.study.stimuli import Stimulus
from tactogram.study.trials import Asked, Given, Page, Participant, Presented, Setting
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

    def _stimuli(self, setting: Setting, participant: Participant) -> Sequence[Stimulus]:
        """Return what this participant meets."""
        return setting.stimuli

    def total(self, setting: Setting) -> int:
        """Return the trials of the first participant."""
        return self.repeats * len(self._stimuli(setting, Participant("", 1)))

    def next_page(self, setting: Setting, participant: Participant, given: Sequence[Given]) -> Page | None:
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
            presented=(Presented("", stimulus),),
            text=self.instructions,
            asked=tuple(self._asked(word, stimulus) for word in words),
            layout=self._layout(),
        )

    def _word_text(self, word: str) -> Wording:
        return self.word_texts.get(word) or Wording(ja=JAPANESE.get(word, word), en=word)

    def _layout(self) -> dict[str, Any]:
        return {}

    def _asked(self, word: str, stimulus: Stimulus) -> Asked:
        raise NotImplementedError


class Rating(WordScales):
    """Words on a scale of steps, felt with or without an image in the line of sight."""

    kind: Literal["rating"] = "rating"
    low: int = 1
    high: int = 7
    """[1], Sec. III-A: "a 7-point unipolar scale ranging from 1 (negative) to 7 (positive)"."""
    low_text: Wording = Wording(ja="まったくあてはまらない", en="not at all")
    high_text: Wording = Wording(ja="非常にあてはまる", en="very much")
    image_mm: float = Field(default=30.0, gt=0, le=1000)
    """Side of the square image, where a stimulus has one ([2], Sec. II-D: "adjusted to a size of 30 mm square")."""
    instructions: Wording = Wording(
        ja="触って、それぞれのことばがどれくらいあてはまるか答えてください。",
        en="Touch it, and say how well each word fits.",
    )

    def check(self, setting: Setting) -> None:
        """Refuse a scale without length."""
        if self.low >= self.high:
            raise ParameterError(f"rating needs low < high, got {self.low} and {self.high}")

    def _layout(self) -> dict[str, Any]:
        return {"image_mm": self.image_mm}

    def _asked(self, word: str, stimulus: Stimulus) -> Asked:
        question = Question(
            id=word,
            text=self._word_text(word),
            kind="steps",
            low=self.low,
            high=self.high,
            low_text=self.low_text,
            high_text=self.high_text,
        )
        return Asked(question, stimulus=stimulus.item, condition=stimulus.condition)


class Evoked(WordScales):
    """Whether the sight of an image evokes what each word says; images come in sets, each judged by some people."""

    kind: Literal["evoked"] = "evoked"
    set_size: int = Field(default=80, ge=1)
    """[2], Sec. II-B: "320 images were divided into four sets, each containing 80 images"."""
    sets: int = Field(default=1, ge=1)
    """How many sets each participant judges, the next ones for the next participant. The paper had 30 participants per
    set and 37 in all, so that most judged several."""
    instructions: Wording = Wording(
        ja="画像を見て、それぞれのことばの触感が喚起されるかどうか答えてください。",
        en="Look at the image, and say whether it evokes each word.",
    )
    evoked: Wording = Wording(ja="喚起される", en="evoked")
    not_evoked: Wording = Wording(ja="喚起されない", en="not evoked")

    def check(self, setting: Setting) -> None:
        """Refuse stimuli without an image, and more sets than there are."""
        for stimulus in setting.stimuli:
            if not stimulus.is_seen:
                raise ParameterError(
                    f"evoked shows images, and stimulus {stimulus.name!r} has none; give image"
                )
        if self.sets > (count := self._set_count(setting)):
            raise ParameterError(
                f"sets must be at most {count}, the number of sets there are, got {self.sets}"
            )

    def for_practice(self, names: Sequence[str]) -> Self:
        """Return it with one set: there are few images to practise on."""
        return self.model_copy(update={"sets": 1})

    def _set_count(self, setting: Setting) -> int:
        return -(-len(setting.stimuli) // self.set_size)

    def _stimuli(self, setting: Setting, participant: Participant) -> Sequence[Stimulus]:
        # Which images make a set is drawn once for the study; which sets come, follows the participant's number.
        count = self._set_count(setting)
        drawn = generator(setting.seed, 0, "sets").permutation(len(setting.stimuli))
        first = (participant.number - 1) * self.sets
        own = [(first + i) % count for i in range(self.sets)]
        return [setting.stimuli[i] for s in own for i in drawn[s * self.set_size : (s + 1) * self.set_size]]

    def _asked(self, word: str, stimulus: Stimulus) -> Asked:
        question = Question(
            id=word,
            text=self._word_text(word),
            kind="choice",
            options=(
                Option(value="evoked", text=self.evoked),
                Option(value="not evoked", text=self.not_evoked),
            ),
        )
        return Asked(
            question,
            stimulus=stimulus.item,
            condition=stimulus.condition,
            values={"evoked": 1.0, "not evoked": 0.0},
        )
