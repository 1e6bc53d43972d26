"""Evoked words: which words the sight of an image evokes.

[1], [2] as in `tactogram_study.designs.single_stimulus`. Answers: a question per word; ``answer`` is ``evoked`` or
``not evoked``, ``value`` 1 or 0.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, Self

from pydantic import Field

from tactogram.errors import ParameterError
from tactogram_study.designs.design import MarginScale
from tactogram_study.designs.single_stimulus import WordScales
from tactogram_study.planned import PowerAssumptions
from tactogram_study.questions import AnswerOption, Question
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, PageQuestion, Participant, generator
from tactogram_study.wording import Wording, text_field

if TYPE_CHECKING:
    pass


class EvokedWords(WordScales):
    """Words evoked by the sight of an image, yes or no; images come in sets, each for some participants."""

    title: ClassVar[str] = "Evoked words"
    question_text: ClassVar[str] = "Which words does an image evoke?"
    margins: ClassVar[Mapping[str, MarginScale]] = {"evoked": MarginScale("of the share of words")}
    analysis: ClassVar[str] = "tactogram_study.designs.analysis.evoked:analyse_evoked"
    drawings: ClassVar[Mapping[str, str]] = {
        "evoked": "tactogram_study.designs.analysis.evoked:evoked_figure"
    }
    power: ClassVar[Mapping[str, PowerAssumptions]] = {
        "evoked": PowerAssumptions(
            "votes", 0.7, "share of people in whom it is evoked", 0.5, 0.0, 0.2,
            (10, 20, 30, 60), (1,), "answers of each participant to an image and word", "exact binomial",
        )
    }  # fmt: skip

    kind: Literal["evoked"] = "evoked"
    set_size: int = Field(default=80, ge=1, title="Pictures in a set")
    """Images in a set ([2], Sec. II-B: "320 images were divided into four sets, each containing 80 images")."""
    sets: int = Field(default=1, ge=1, title="Sets for each participant")
    """Sets per participant, the next ones for the next participant. The paper had 30 participants per set and 37 in
    all, so that most rated several."""
    instructions: Wording = text_field("evoked_instructions")
    evoked: Wording = text_field("evoked_evoked", "Answer: yes")
    not_evoked: Wording = text_field("evoked_not_evoked", "Answer: no")

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` for stimuli without an image, and for more sets than there are."""
        for stimulus in setting.stimuli:
            if not stimulus.is_seen:
                raise ParameterError(
                    f"evoked shows images, and stimulus {stimulus.name!r} has none; give image"
                )
        if self.sets > (count := self._set_count(setting)):
            raise ParameterError.must("sets", f"be at most {count}, the number of sets there are", self.sets)

    def practice_design(self, names: Sequence[str]) -> Self:
        """Return the design with one set: a practice has few images."""
        return self.model_copy(update={"sets": 1})

    def _set_count(self, setting: DesignContext) -> int:
        return -(-len(setting.stimuli) // self.set_size)

    def stimuli_of(self, setting: DesignContext, participant: Participant) -> Sequence[Stimulus]:
        # The images of a set are drawn once for the study; the sets follow from the participant's number.
        count = self._set_count(setting)
        drawn = generator(setting.seed, 0, "sets").permutation(len(setting.stimuli))
        first = (participant.number - 1) * self.sets
        chosen = [(first + i) % count for i in range(self.sets)]
        return [
            setting.stimuli[i] for s in chosen for i in drawn[s * self.set_size : (s + 1) * self.set_size]
        ]

    def word_question(self, word: str, stimulus: Stimulus) -> PageQuestion:
        question = Question(
            id=word,
            text=self.word_text(word),
            kind="choice",
            options=(
                AnswerOption(value="evoked", text=self.evoked),
                AnswerOption(value="not evoked", text=self.not_evoked),
            ),
        )
        return PageQuestion(
            question,
            stimulus=stimulus.item,
            condition=stimulus.condition,
            values={"evoked": 1.0, "not evoked": 0.0},
        )
