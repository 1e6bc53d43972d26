"""Magnitude estimation: a number for how strong something feels, in proportion.

S. S. Stevens, "On the psychophysical law", Psychol. Rev. 64, 153-181 (1957).

Answers to the question ``magnitude``: ``value`` is the estimate.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from tactogram.errors import ParameterError
from tactogram_study.designs.design import MarginScale, check_standard
from tactogram_study.designs.single_stimulus import SingleStimulus
from tactogram_study.planned import PowerAssumptions
from tactogram_study.questions import Question
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import (
    DesignContext,
    History,
    Page,
    PageQuestion,
    Participant,
    PresentedStimulus,
)
from tactogram_study.wording import Wording, text_field

if TYPE_CHECKING:
    from tactogram_study.simulated_observer import SimulatedObserver

SMALLEST = 1e-9
"""Smallest valid number: magnitudes are ratios, so 0 is none."""


class MagnitudeEstimation(SingleStimulus):
    """Settings of a magnitude estimation."""

    title: ClassVar[str] = "Magnitude estimation"
    question_text: ClassVar[str] = "How strong does it feel, as a number?"
    margins: ClassVar[Mapping[str, MarginScale]] = {"magnitude": MarginScale("of the exponent")}
    analysis: ClassVar[str] = "tactogram_study.designs.analysis.magnitude:analyse_magnitude"
    drawings: ClassVar[Mapping[str, str]] = {
        "magnitude": "tactogram_study.designs.analysis.magnitude:magnitude_figure",
    }
    power: ClassVar[Mapping[str, PowerAssumptions]] = {
        "magnitude": PowerAssumptions(
            "slopes", 0.1, "of the exponent from 1 (trial_sd: of log estimates)", 0.15, 0.3, 0.1,
            (8, 16), (3, 6), "estimates of each of five intensities over a factor of 16", "t of slopes",
        )
    }  # fmt: skip
    columns: ClassVar[Mapping[str, str]] = {"modulus": "Number that the standard stands for"}

    kind: Literal["magnitude"] = "magnitude"
    standard: str = Field(default="", title="Standard")
    """Name of a stimulus that is A on each page and counts as ``modulus``; without one, people choose their scale."""
    modulus: float = Field(
        default=10.0, gt=0, allow_inf_nan=False, title="Number that the standard stands for"
    )
    repeats: int = Field(default=3, ge=1, le=1000, title="Repeats of each stimulus")
    instructions: Wording = text_field("magnitude_instructions")
    with_standard: Wording = text_field("magnitude_with_standard", "Text above each trial with a standard")
    magnitude: Wording = text_field("magnitude_magnitude", "Question")

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` for an unknown standard, or nothing to estimate."""
        check_standard(self.standard, setting)
        if not self.stimuli_of(setting, Participant("", 1)):
            raise ParameterError("magnitude needs a stimulus besides its standard, got none")

    def stimuli_of(self, setting: DesignContext, participant: Participant) -> Sequence[Stimulus]:
        return [stimulus for stimulus in setting.stimuli if stimulus.name != self.standard]

    def next_page(self, setting: DesignContext, participant: Participant, history: History) -> Page | None:
        page = super().next_page(setting, participant, history)
        standard = setting.stimulus(self.standard)
        if page is None or standard is None:
            return page
        return replace(
            page,
            presented=(PresentedStimulus("A", standard), PresentedStimulus("B", page.presented[0].stimulus)),
            text=self.with_standard.filled(modulus=f"{self.modulus:g}"),
            more={"modulus": f"{self.modulus:g}"},
        )

    def questions_about(
        self, stimulus: Stimulus, *, setting: DesignContext, participant: Participant, trial: int
    ) -> tuple[PageQuestion, ...]:
        standard = setting.stimulus(self.standard)
        question = PageQuestion(
            Question(id="magnitude", text=self.magnitude, kind="number", low=SMALLEST),
            stimulus=stimulus.item,
            condition=stimulus.condition,
            other=standard.item if standard else "",
            other_condition=standard.condition if standard else "",
        )
        return (question,)

    @classmethod
    def simulated_answer(cls, page: Page, question: PageQuestion, participant: SimulatedObserver) -> str:
        """Return a number that grows with intensity by the participant's power law."""
        return participant.number(question, participant.exponent * _log_intensity(page))


def _log_intensity(page: Page) -> float:
    """Return log10 of the estimated stimulus's intensity, 0 where the level does not give it."""
    estimated = page.presented[-1]
    kind, _, number = (estimated.stimulus.level if estimated.stimulus else "").partition("=")
    level = math.log10(float(number)) if kind in ("gain", "peak") else 0.0
    return level + estimated.gain_db / 20
