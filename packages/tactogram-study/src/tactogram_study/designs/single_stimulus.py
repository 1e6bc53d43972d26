"""Base of designs that ask about one stimulus at a time, each equally often, in the study's order."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

from pydantic import Field

from tactogram_study.designs.design import Design
from tactogram_study.orders import ordered
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, Page, PageAnswers, PageQuestion, Participant


class SingleStimulus(Design):
    """A design with a page per stimulus; a subclass defines its questions in `questions_about`."""

    repeats: int = Field(default=1, ge=1, le=1000)
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

    def next_page(
        self, setting: DesignContext, participant: Participant, history: Sequence[PageAnswers]
    ) -> Page | None:
        stimuli = self.stimuli_of(setting, participant)
        if len(history) == self.repeats * len(stimuli):
            return None
        order = ordered(
            range(len(stimuli)),
            rule=setting.order,
            repeats=self.repeats,
            seed=setting.seed,
            participant=participant.number,
        )
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
