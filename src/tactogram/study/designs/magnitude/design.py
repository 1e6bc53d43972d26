"""Magnitude estimation: a number for how strong something feels, in proportion.

S. S. Stevens, "On the psychophysical law", Psychol. Rev. 64, 153-181 (1957).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from tactogram.errors import ParameterError
from tactogram.study.designs.design import Design
from tactogram.study.orders import ordered
from tactogram.study.questions import Question
from tactogram.study.stimuli import Stimulus
from tactogram.study.trials import (
    DesignContext,
    Page,
    PageAnswers,
    PageQuestion,
    Participant,
    PresentedStimulus,
    Slot,
)
from tactogram.study.wording import Wording

SMALLEST = 1e-9
"""Smallest number that is taken: magnitudes are ratios, so 0 is none."""


class MagnitudeEstimation(Design):
    """Values of a magnitude estimation."""

    kind: Literal["magnitude"] = "magnitude"
    standard: str = ""
    """Name of a stimulus shown as A on each page, whose number is ``modulus``; "" lets people choose their own."""
    modulus: float = Field(default=10.0, gt=0, allow_inf_nan=False)
    repeats: int = Field(default=3, ge=1, le=1000)
    instructions: Wording = Wording(
        ja="感じた強さを、比率が合うように数で答えてください。",
        en="Say how strong it feels by a number: what feels twice as strong gets twice the number.",
    )
    with_standard: Wording = Wording(
        ja="Aの強さを{modulus}とします。Bの強さはいくつですか。",
        en="A counts as {modulus}. How strong is B?",
    )
    magnitude: Wording = Wording(ja="強さ", en="How strong is it?")

    def check(self, setting: DesignContext) -> None:
        """Refuse a standard that is not there."""
        names = [stimulus.name for stimulus in setting.stimuli]
        if self.standard and self.standard not in names:
            raise ParameterError(f"standard must be one of {', '.join(names)}, got {self.standard!r}")
        if not self._judged(setting):
            raise ParameterError("magnitude needs a stimulus besides its standard, got none")

    def total(self, setting: DesignContext) -> int:
        """Return repeats times stimuli."""
        return self.repeats * len(self._judged(setting))

    def next_page(
        self, setting: DesignContext, participant: Participant, given: Sequence[PageAnswers]
    ) -> Page | None:
        """Return the page of the next stimulus."""
        judged = self._judged(setting)
        if len(given) == self.repeats * len(judged):
            return None
        rule, seed, number = setting.order, setting.seed, participant.number
        order = ordered(range(len(judged)), rule=rule, repeats=self.repeats, seed=seed, participant=number)
        trial = len(given) + 1
        block, repeat, which = order[trial - 1]
        stimulus = judged[which]
        standard = next((s for s in setting.stimuli if s.name == self.standard), None)
        slot: Slot = "B" if standard else ""
        shown = PresentedStimulus(slot, stimulus)
        question = Question(id="magnitude", text=self.magnitude, kind="number", low=SMALLEST)
        return Page(
            token=f"trial-{trial}.1",
            kind=self.kind,
            trial=trial,
            block=block,
            repeat=repeat,
            total=len(order),
            presented=(PresentedStimulus("A", standard), shown) if standard else (shown,),
            text=self.with_standard.filled(modulus=f"{self.modulus:g}") if standard else self.instructions,
            asked=(
                PageQuestion(
                    question,
                    stimulus=stimulus.item,
                    condition=stimulus.condition,
                    other=standard.item if standard else "",
                    other_condition=standard.condition if standard else "",
                ),
            ),
            more={"modulus": f"{self.modulus:g}"} if standard else {},
        )

    def _judged(self, setting: DesignContext) -> list[Stimulus]:
        return [stimulus for stimulus in setting.stimuli if stimulus.name != self.standard]
