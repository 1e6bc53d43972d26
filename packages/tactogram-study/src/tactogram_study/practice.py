"""Practice before the trials: a few trials of the study's design, whose answers are stored and marked.

A practice page is a page of the design, with stimuli of the study or of the practice; its token begins with
``practice-``, and its rows have the design ``practice``, so that no analysis includes them. Its order has a seed of its
own: the trials are the same with and without it.
"""

from __future__ import annotations

import zlib
from dataclasses import replace
from typing import Any, Self

from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram.validation import DescribedModel
from tactogram_study.designs import Design
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import DesignContext, History, Page, PageAnswers, Participant
from tactogram_study.wording import Wording, text_field

TOKEN = "practice-"
MARK = "practice"
"""Design of the rows; their extra column of this name is the design that was practised."""


class Practice(DescribedModel):
    """Content of the table ``practice`` in a study's file."""

    trials: int = Field(ge=1, le=100)
    feedback: bool = False
    """Whether participants see if an answer was right; only where answers can be."""
    stimuli: tuple[str, ...] = ()
    """Names of the study's stimuli in the practice; by default all, or none if there are ``own`` ones."""
    own: tuple[Stimulus, ...] = ()
    """Stimuli of the practice only, so that nothing is learned of those that count."""
    text: Wording = text_field("practice_text")
    right: Wording = text_field("practice_right")
    wrong: Wording = text_field("practice_wrong")
    ended: Wording = text_field("practice_ended")

    @model_validator(mode="after")
    def _once(self) -> Self:
        names = [*self.stimuli, *(stimulus.name for stimulus in self.own)]
        if twice := [name for name in names if names.count(name) > 1]:
            raise ValueError(f"practice names {twice[0]!r} twice")
        return self

    def check(self, design: Design, setting: DesignContext) -> None:
        """Raise `ParameterError` for unknown or too few stimuli, and for feedback where no answer is right."""
        known = [stimulus.name for stimulus in setting.stimuli]
        for name in self.stimuli:
            if name not in known:
                raise ParameterError("practice", f"stimuli must be of {', '.join(known[:12])}, got {name!r}")
        for stimulus in self.own:
            if stimulus.name in known:
                raise ParameterError(
                    "practice", f"own stimulus {stimulus.name!r} is one of the study; name it in stimuli"
                )
        if self.feedback and not design.has_right_answers:
            raise ParameterError(
                "practice", f"feedback needs answers that are right or wrong, which {design.kind} has not"
            )
        practised, context = self._design(design, setting), self.setting(setting)
        try:
            practised.check(context)
        except ParameterError as error:
            raise ParameterError("practice", error) from None
        if (most := practised.total(context)) < self.trials:
            raise ParameterError(
                "practice", f"trials must be at most {most}, those of the design, got {self.trials}"
            )

    def setting(self, setting: DesignContext) -> DesignContext:
        """Return the context of the practice: its stimuli, and a seed of its own."""
        every = self.stimuli or (() if self.own else tuple(stimulus.name for stimulus in setting.stimuli))
        chosen = tuple(stimulus for stimulus in setting.stimuli if stimulus.name in every)
        seed = zlib.crc32(f"practice of {setting.seed}".encode())
        return replace(setting, seed=seed, stimuli=(*chosen, *self.own))

    def next_page(
        self, design: Design, setting: DesignContext, participant: Participant, history: History
    ) -> Page | None:
        """Return the practice page after ``history``, the answered practice pages in order; None at its end."""
        page = self._page(design, setting, participant, history)
        if page is None or not history:
            return page
        return replace(
            page, layout={**page.layout, **self.feedback_text(design, setting, participant, history)}
        )

    def first_trial(
        self,
        page: Page,
        design: Design,
        setting: DesignContext,
        participant: Participant,
        history: History,
    ) -> Page:
        """Return the first trial with the text that ends the practice, shown before it."""
        ended = {"text": self.ended, **self.feedback_text(design, setting, participant, history)}
        return replace(page, layout={**page.layout, "practice_ended": ended})

    def feedback_text(
        self, design: Design, setting: DesignContext, participant: Participant, history: History
    ) -> dict[str, Any]:
        """Return the feedback to the last answer: whether it was right; {} without feedback or a right answer."""
        before = self._page(design, setting, participant, history[:-1]) if self.feedback and history else None
        questions = [question for question in before.questions if question.right] if before else []
        if not questions:
            return {}
        correct = all(history[-1].responses[question.key] == question.right for question in questions)
        return {"feedback": {"correct": correct, "text": self.right if correct else self.wrong}}

    def _page(
        self, design: Design, setting: DesignContext, participant: Participant, history: History
    ) -> Page | None:
        page = self._design(design, setting).next_page(self.setting(setting), participant, history)
        if page is None or page.trial > self.trials:
            return None
        number, of = str(page.trial), str(self.trials)
        about = {
            "number": page.trial,
            "of": self.trials,
            "feedback": self.feedback,
            "text": self.text.filled(number=number, of=of),
        }
        return replace(
            page,
            token=f"{TOKEN}{page.trial}.{page.step}",
            total=self.trials,
            practice=True,
            layout={**page.layout, "practice": about},
        )

    def _design(self, design: Design, setting: DesignContext) -> Design:
        return design.practice_design([stimulus.name for stimulus in self.setting(setting).stimuli])


def practice_answers(history: History) -> list[PageAnswers]:
    """Return the answered practice pages."""
    return [page for page in history if page.token.startswith(TOKEN)]
