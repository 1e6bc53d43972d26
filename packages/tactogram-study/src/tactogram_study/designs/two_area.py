"""Two areas side by side, one recorded and one generated: which is generated, and how real is each.

The experiment of Saga, Agatsuma, Vasilache and Takahashi, "Machine Learning-based Classification and Generation of
Vibrotactile Information" (Sec. IV-A), by the method of Ujitoko et al.: "Either tactile sensation derived from training
data or the generated data is presented in A or B"; a target moves at 500 mm/s and the finger follows; after that the
real texture is stroked and a 100 mm visual analogue scale is marked for each. Ten trials for each of nine textures.

Answers to the question ``which``: ``stimulus`` and ``condition`` are those of the target, ``other`` is the same texture
in the other version; ``side`` and ``answer`` are A or B; ``value`` is 1 if correct, else 0. To ``realism``: those of
the rated version; ``value`` is the mark in mm, ``side`` its slot.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from pydantic import Field

from tactogram.errors import DataError, ParameterError
from tactogram_study.designs.design import Design, MarginScale, ab_question, pairs_by_item
from tactogram_study.planned import GEE, PowerAssumptions
from tactogram_study.questions import Question
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import (
    DesignContext,
    History,
    Page,
    PageQuestion,
    Participant,
    Slot,
    balanced_sides,
    generator,
)
from tactogram_study.wording import Wording, text_field

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tactogram_study.analysis.findings import AnalysisSection
    from tactogram_study.answers import Answers
    from tactogram_study.planned import AnalysisPlan

WHICH, REALISM = "which", "realism"


class TwoArea(Design):
    """Settings of a two-area test; the defaults are those of the paper."""

    title: ClassVar[str] = "Two areas"
    question_text: ClassVar[str] = "Which of two areas is generated, and how real is each?"
    has_right_answers: ClassVar[bool] = True
    margins: ClassVar[Mapping[str, MarginScale]] = {
        WHICH: MarginScale("of the share correct", below=0.5),
        REALISM: MarginScale("mm"),
    }
    power: ClassVar[Mapping[str, PowerAssumptions]] = {
        "two_area": PowerAssumptions(
            "share", 0.6, "share correct of a typical participant (person_sd: of logits)", 0.4, 0.0, 0.1,
            (10, 20), (10, 30, 90), "answers of each participant", GEE,
        ),
        REALISM: PowerAssumptions(
            "means", 5.0, "mm between conditions", 5.0, 15.0, 5.0,
            (10, 20), (10, 90), "marks of each participant and condition", "paired t",
        ),
    }  # fmt: skip

    labels: ClassVar[Mapping[str, str]] = {
        "sides.random": "drawn",
        "sides.balanced": "each equally often",
    }

    kind: Literal["two_area"] = "two_area"
    asked_for: str = Field(default="generated", title="Condition that participants look for")
    """Condition of the target."""
    against: str = Field(default="recorded", title="Condition in the other area")
    """Condition of the other area."""
    repeats: int = Field(default=10, ge=1, le=1000, title="Repeats of each item")
    """Trials of each texture (Sec. IV-A: "Ten trials were performed for each texture")."""
    sides: Literal["random", "balanced"] = Field(default="random", title="Side of each trial")
    """``random`` draws the side of each trial, as the paper did; ``balanced`` has each equally often per texture."""
    realism: bool = Field(default=True, title="Ask how real each feels after each choice")
    """Whether realism is rated after each choice."""
    vas_mm: float = Field(default=100.0, gt=0, le=1000, title="Length of that scale, mm")
    """Length of the scale."""
    speed_mm_s: float = Field(default=500.0, gt=0, le=5000, title="Speed of the target, mm/s")
    """Speed of the target (Sec. IV-A)."""
    area_mm: tuple[float, float] = Field(default=(180.0, 20.0), title="Width and height of an area, mm")
    """Width and height of an area. The paper says "two rectangle areas" on a tablet, and no size. A tablet of 10 inches
    held sideways shows 195 mm by 135 mm or more: 180 mm is about as wide as it can be, and two areas of 20 mm fit
    above each other with both scales below. The target (12 mm) then has 168 mm of way and turns three times a second at
    500 mm/s; on 80 mm it would turn seven times, which no finger follows."""
    instructions: Wording = text_field("two_area_instructions")
    which: Wording = text_field("two_area_which", "Question")
    reference: Wording = text_field("two_area_reference", "Text before the question how real each feels")
    real: Wording = text_field("two_area_real", "Question how real it feels")
    least: Wording = text_field("two_area_least", "Lower end of that scale")
    most: Wording = text_field("two_area_most", "Upper end of that scale")

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` for a texture that lacks one of the two conditions."""
        pairs = pairs_by_item(setting.stimuli, self.asked_for, self.against)
        paired = {stimulus.item for pair in pairs for stimulus in pair}
        for stimulus in setting.stimuli:
            if stimulus.condition not in (self.asked_for, self.against) or stimulus.item not in paired:
                raise ParameterError(
                    f"two_area needs each item as {self.asked_for!r} and as {self.against!r}, got {stimulus.name!r} "
                    f"with condition {stimulus.condition!r}"
                )

    def total(self, setting: DesignContext) -> int:
        return self.repeats * len(pairs_by_item(setting.stimuli, self.asked_for, self.against))

    def next_page(self, setting: DesignContext, participant: Participant, history: History) -> Page | None:
        """Return the next of the two pages of each trial."""
        trials = self._trials(setting, participant)
        done, step = divmod(len(history), 2 if self.realism else 1)
        if done == len(trials):
            return None
        block, repeat, pair, side = trials[done]
        target, other = pair
        a, b = pair if side == "A" else pair[::-1]
        text, questions = self.instructions, [ab_question(WHICH, self.which, target, other, side)]
        if step:
            text = self.reference.filled(item=setting.names.get(a.item, a.item))
            questions = [self._realism("A", a, b), self._realism("B", b, a)]
        return self.trial_page(
            done + 1,
            questions,
            {"A": a, "B": b},
            step=step + 1,
            block=block,
            repeat=repeat,
            total=len(trials),
            text=text,
            layout={
                "target_speed_mm_s": self.speed_mm_s,
                "area_mm": list(self.area_mm),
                "vas_mm": self.vas_mm,
            },
        )

    @classmethod
    def analyse(cls, answers: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
        """Return the share correct, and the difference of the marks for realism."""
        from tactogram_study.analysis.discrimination import analyse_discrimination
        from tactogram_study.designs.analysis.two_area import analyse_realism
        from tactogram_study.statistics import d_prime_2afc

        sections = []
        for question, rows in answers.by("question").items():
            margin = plan.margins.get(question)
            if question == WHICH:
                sections.append(
                    analyse_discrimination(
                        rows,
                        title="Which is generated?",
                        d_prime=d_prime_2afc,
                        margin=margin,
                        alpha=plan.alpha,
                        printed=True,
                    )
                )
            elif question == REALISM:
                sections.append(analyse_realism(rows, margin=margin))
            else:
                raise DataError(f"two_area: question must be {WHICH} or {REALISM}, got {question!r}")
        return sections

    @classmethod
    def figures(cls, section: AnalysisSection, answers: Answers) -> dict[str, Figure]:
        from tactogram_study.analysis.figures import correct_figure
        from tactogram_study.designs.analysis.two_area import realism_figure

        if section.question == WHICH:
            return {"two_area_correct": correct_figure(section)}
        return {"two_area_realism": realism_figure(section)}

    def power_options(self, setting: DesignContext) -> dict[str, Any]:
        return {"trials": (self.total(setting),)}

    def _trials(
        self, setting: DesignContext, participant: Participant
    ) -> list[tuple[int, int, tuple[Stimulus, Stimulus], str]]:
        """Return (block, repeat, pair, side of the target) of each trial."""
        pairs = pairs_by_item(setting.stimuli, self.asked_for, self.against)
        order = setting.ordered(range(len(pairs)), participant, repeats=self.repeats)
        rng = generator(setting.seed, participant.number, "sides")
        if self.sides == "random":
            drawn = rng.integers(2, size=len(order))
            return [
                (block, repeat, pairs[i], "AB"[k]) for (block, repeat, i), k in zip(order, drawn, strict=True)
            ]
        sides = [balanced_sides(self.repeats, rng) for _ in pairs]
        return [(block, repeat, pairs[i], sides[i][repeat - 1]) for block, repeat, i in order]

    def _realism(self, slot: Slot, rated: Stimulus, other: Stimulus) -> PageQuestion:
        question = Question(
            id=REALISM,
            text=self.real,
            kind="vas",
            low=0,
            high=self.vas_mm,
            low_text=self.least,
            high_text=self.most,
        )
        return PageQuestion(
            question,
            slot=slot,
            side=slot,
            stimulus=rated.item,
            condition=rated.condition,
            other=other.item,
            other_condition=other.condition,
        )
