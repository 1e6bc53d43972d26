"""What every design promises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict

from tactogram.study.questions import AnswerOption, Question
from tactogram.study.stimuli import Stimulus
from tactogram.study.trials import DesignContext, Page, PageAnswers, Participant
from tactogram.study.wording import Wording


class Design(BaseModel, ABC):
    """A way of asking: its values from the file, and what follows from them.

    ``next_page`` is a pure function of the study, the participant and the answers so far. Resuming after a crash is
    calling it with the answers that were stored.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    has_right_answers: ClassVar[bool] = False
    """Whether an answer can be right or wrong."""
    instructions: Wording = Wording()
    """Shown above each trial; each design has its own by default."""

    @abstractmethod
    def check(self, setting: DesignContext) -> None:
        """Refuse stimuli that the design cannot ask about.

        Raises
        ------
        ParameterError
        """

    @abstractmethod
    def next_page(
        self, setting: DesignContext, participant: Participant, given: Sequence[PageAnswers]
    ) -> Page | None:
        """Return the page after ``given``, the answers to this design's pages in order; None at the end."""

    @abstractmethod
    def total(self, setting: DesignContext) -> int:
        """Return how many trials a participant has, or has at most."""

    def for_practice(self, names: Sequence[str]) -> Self:
        """Return the design that is practised on the stimuli of these names."""
        return self


def ab_question(identifier: str, text: Wording, **more: Any) -> Question:
    """Return a choice between the two slots."""
    return Question(
        id=identifier,
        text=text,
        kind="choice",
        options=(AnswerOption(value="A"), AnswerOption(value="B")),
        **more,
    )


def pairs_by_item(stimuli: Sequence[Stimulus], first: str, second: str) -> list[tuple[Stimulus, Stimulus]]:
    """Return the stimuli of each item that has both conditions, in the order of the file."""
    of = {(stimulus.item, stimulus.condition): stimulus for stimulus in stimuli}
    items = dict.fromkeys(stimulus.item for stimulus in stimuli)
    return [
        (of[item, first], of[item, second]) for item in items if (item, first) in of and (item, second) in of
    ]
