"""Study design: what every design declares, and what follows from it where a design says nothing else.

Analysis, figures and power import their libraries when they are called, so that designs can be listed without them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Self

from pydantic import BaseModel, ConfigDict

from tactogram.study.power.assumptions import PowerAssumptions
from tactogram.study.questions import AnswerOption, Question
from tactogram.study.stimuli import Stimulus
from tactogram.study.trials import DesignContext, Page, PageAnswers, PageQuestion, Participant
from tactogram.study.wording import Wording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tactogram.study.analysis.findings import AnalysisSection
    from tactogram.study.answers import Answers
    from tactogram.study.power.methods import PowerMethod
    from tactogram.study.simulated_participants import SimulatedParticipant
    from tactogram.study.study_analysis import AnalysisPlan


@dataclass(frozen=True)
class MarginScale:
    """Scale of a margin of equivalence.

    Parameters
    ----------
    unit : str
        As people read it after the number.
    below : float
        Every margin must be smaller: one half for a share around one half.
    """

    unit: str
    below: float = math.inf


class Design(BaseModel, ABC):
    """A study design: its values from a study's file, and how it is asked, simulated, analysed and drawn.

    A design names its ``kind``, and says with `next_page` and `total` what a participant is shown. Everything else has
    a default. Its class variables and class methods hold for every study of the kind, also for a table of answers that
    came without its study.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    title: ClassVar[str] = ""
    """What it is called in lists and reports."""
    question_text: ClassVar[str] = ""
    """What it asks, in a sentence."""
    has_right_answers: ClassVar[bool] = False
    """Whether an answer can be right or wrong."""
    gives_targets: ClassVar[bool] = False
    """Whether its answers are scores of words by item, which another study's scores can be held against."""
    margins: ClassVar[Mapping[str, MarginScale]] = {}
    """What a margin of equivalence can be given for: a question, or a measure over all questions."""
    power: ClassVar[Mapping[str, PowerAssumptions]] = {}
    """Its power tables by name, its own question first."""
    columns: ClassVar[Mapping[str, str]] = {}
    """Descriptions of further columns of its answers, and of columns that hold something else than elsewhere."""
    key_columns: ClassVar[tuple[str, ...]] = ()
    """Further columns that hold keys of items, conditions or stimuli."""

    kind: str
    """What a study's file calls the design; a subclass fixes it: ``kind: Literal["abx"] = "abx"``."""
    instructions: Wording = Wording()
    """Shown above each trial; each design has its own by default."""

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
        """Return the page after ``given``, the answers to this design's pages in order; None at the end.

        A pure function of the study, the participant and the answers so far: resuming after a crash is calling it with
        the answers that were stored. What the page's ``layout`` can say is in ``studio/participants/static``:
        ``presentation`` ("intervals": one stimulus after the other), ``area_mm`` and ``target_speed_mm_s`` (areas to
        stroke), ``vas_mm``, ``image_mm``, ``at_most`` (whether the total is the most there can be).
        """

    @abstractmethod
    def total(self, setting: DesignContext) -> int:
        """Return how many trials a participant has, or has at most."""

    def practice_design(self, names: Sequence[str]) -> Self:
        """Return the design that is practised on the stimuli of these names."""
        return self

    def check_margins(self, names_and_values: Mapping[str, float]) -> None:
        """Refuse margins that the design does not take, or that are too wide.

        Raises
        ------
        ValueError
        """
        for name, value in names_and_values.items():
            if name not in self.margins:
                known = ", ".join(self.margins) or "nothing"
                raise ValueError(
                    f"analysis.margins: a study of design {self.kind} takes margins for {known}, got {name!r}"
                )
            if not value < (most := self.margins[name].below):
                raise ValueError(
                    f"analysis.margins: the margin of {name} must be below {most:g}, got {value:g}"
                )

    @classmethod
    def margin_for(cls, question: str) -> str:
        """Return the name of the margin that answers to a question are held against, "" if there is none."""
        names = tuple(cls.margins)
        return question if question in names else names[0] if len(names) == 1 else ""

    @classmethod
    def analyse(cls, answers: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
        """Return what answers to trials of this kind show, a section per question.

        By default means by participant, of every stimulus and condition, and the differences between conditions.

        Raises
        ------
        DataError
            If the answers cannot be analysed.
        """
        from tactogram.study.analysis.means import analyse_means

        return [
            analyse_means(rows, title=cls.title, margin=plan.margins.get(cls.margin_for(question)))
            for question, rows in answers.by("question").items()
        ]

    @classmethod
    def figures(cls, section: AnalysisSection, answers: Answers) -> dict[str, Figure]:
        """Return the figures of a section by file name, without suffix.

        Parameters
        ----------
        section : AnalysisSection
            One that `analyse` returned.
        answers : Answers
            What it was made from.
        """
        from tactogram.study.analysis.figures import means_figure

        return {f"{section.design}_{section.question}": means_figure(section)}

    @classmethod
    def power_method(cls, kind: str) -> PowerMethod:
        """Return how the studies of a power table are simulated, by the ``kind`` of its assumptions."""
        from tactogram.study.power.methods import METHODS

        return METHODS[kind]

    def power_options(self, setting: DesignContext) -> dict[str, Any]:
        """Return what the study says of the options of its power table: ``trials``, ``items``."""
        return {}

    @classmethod
    def simulated_answer(cls, page: Page, asked: PageQuestion, participant: SimulatedParticipant) -> str:
        """Return what a simulated participant answers to a question of a page.

        By default the right answer as often as `simulated_share` says; else by what is typical of the item, the effect
        that was put in, the participant's bias and noise.
        """
        if asked.right:
            return participant.right_or_wrong(asked, cls.simulated_share(page, participant))
        if asked.question.kind == "choice":
            return participant.choice(asked)
        return "(simulated)" if asked.question.kind == "text" else participant.on_scale(asked)

    @classmethod
    def simulated_share(cls, page: Page, participant: SimulatedParticipant) -> float:
        """Return how likely a simulated participant is right; by default as with two alternatives."""
        return participant.two_alternatives()


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
