"""Study design: the declarations of every design, and their defaults.

Analysis, figures and power import their libraries when they are called, so that designs can be listed without them.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pkgutil import resolve_name
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self

from tactogram.errors import ParameterError
from tactogram.validation import DescribedModel
from tactogram_study.planned import PowerAssumptions
from tactogram_study.questions import AnswerOption, Question
from tactogram_study.stimuli import Stimulus
from tactogram_study.trials import (
    DesignContext,
    History,
    Page,
    PageQuestion,
    Participant,
    PresentedStimulus,
    Slot,
)
from tactogram_study.wording import Wording

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tactogram_study.analysis.findings import AnalysisSection
    from tactogram_study.answers import Answers
    from tactogram_study.planned import AnalysisPlan
    from tactogram_study.power import PowerMethod
    from tactogram_study.simulated_observer import SimulatedObserver


@dataclass(frozen=True)
class MarginScale:
    """Scale of a margin of equivalence: its unit as text, and a limit, one half for a share around one half."""

    unit: str
    below: float = math.inf


class Design(DescribedModel, ABC):
    """A study design: its settings in a study's file, and how it is presented, simulated, analysed and drawn.

    A design defines its ``kind``, `next_page` and `total`; everything else has a default. Class variables and class
    methods hold for every study of the kind, also for a table of answers without its study.
    """

    title: ClassVar[str] = ""
    """Title in lists and reports."""
    question_text: ClassVar[str] = ""
    """Its question, in a sentence."""
    has_right_answers: ClassVar[bool] = False
    """Whether an answer can be right or wrong."""
    gives_targets: ClassVar[bool] = False
    """Whether its answers are scores of words by item, which can be targets of another study's scores."""
    margins: ClassVar[Mapping[str, MarginScale]] = {}
    """Scales of its margins of equivalence, by question, or by measure over all questions."""
    power: ClassVar[Mapping[str, PowerAssumptions]] = {}
    """Power tables by name, that of its main question first."""
    columns: ClassVar[Mapping[str, str]] = {}
    """Descriptions of extra columns of its answers, and of columns that differ from other designs."""
    key_columns: ClassVar[tuple[str, ...]] = ()
    """Extra columns with keys of items, conditions or stimuli."""
    analysis: ClassVar[str] = ""
    """Analysis of its answers as ``module:function``, called with the answers and ``margin``; by default that of means.
    A name rather than a function, so that its libraries are imported when it is called; likewise the figures."""
    drawings: ClassVar[Mapping[str, str]] = {}
    """Figures of a section, as ``module:function`` by file name; by default that of means."""
    simulation: ClassVar[str] = ""
    """Its power method, as ``module:class``; by default one of `tactogram_study.power.METHODS`."""

    labels: ClassVar[Mapping[str, str]] = {}
    """Labels of choices in forms, by ``KEY.VALUE``; that of a setting is the ``title`` of its field."""

    kind: str
    """Name of the design in a study's file; a subclass fixes it: ``kind: Literal["abx"] = "abx"``."""
    instructions: Wording = Wording()
    """Text above each trial; each design has a default."""

    def check(self, setting: DesignContext) -> None:
        """Raise `ParameterError` for stimuli that the design cannot ask about."""

    @abstractmethod
    def next_page(self, setting: DesignContext, participant: Participant, history: History) -> Page | None:
        """Return the page after ``history``, this design's answered pages in order; None at the end.

        A pure function of the study, the participant and the answers so far: a session resumes after a crash by calling
        it with the stored answers. ``studio/participants/static`` reads the page's ``layout``: ``presentation``
        ("intervals": one stimulus after the other), ``area_mm`` and ``target_speed_mm_s`` (areas to stroke),
        ``vas_mm``, ``image_mm``, ``at_most`` (whether the total is an upper limit).
        """

    def trial_page(
        self,
        trial: int,
        questions: Sequence[PageQuestion],
        slots: Mapping[Slot, Stimulus | None],
        *,
        step: int = 1,
        gains_db: Mapping[Slot, float] = MappingProxyType({}),
        **values: Any,
    ) -> Page:
        """Return a page of a trial with stimuli by slot; ``values`` are further ones of the `Page`."""
        return Page(
            token=f"trial-{trial}.{step}",
            kind=self.kind,
            questions=tuple(questions),
            presented=tuple(
                PresentedStimulus(slot, stimulus, gains_db.get(slot, 0.0)) for slot, stimulus in slots.items()
            ),
            trial=trial,
            step=step,
            **{"text": self.instructions} | values,
        )

    @abstractmethod
    def total(self, setting: DesignContext) -> int:
        """Return the number of trials of a participant, or its upper limit."""

    def practice_design(self, names: Sequence[str]) -> Self:
        """Return the design of a practice with the stimuli of these names."""
        return self

    def check_margins(self, margins: Mapping[str, float]) -> None:
        """Raise `ParameterError` for margins that the design lacks, or that are too wide."""
        for name, value in margins.items():
            if name not in self.margins:
                known = ", ".join(self.margins) or "nothing"
                problem = f"a study of design {self.kind} takes margins for {known}, got {name!r}"
                raise ParameterError("analysis.margins", problem)
            if not value < (most := self.margins[name].below):
                problem = f"the margin of {name} must be below {most:g}, got {value:g}"
                raise ParameterError("analysis.margins", problem)

    @classmethod
    def margin_for(cls, question: str) -> str:
        """Return the name of a question's margin, "" if there is none."""
        names = tuple(cls.margins)
        return question if question in names else names[0] if len(names) == 1 else ""

    @classmethod
    def analyse(cls, answers: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
        """Return the analysis of answers to trials of this kind, a section per question.

        By default that of ``analysis``, or means by participant, of every stimulus and condition, and the differences
        between conditions. Raises `DataError` if the answers cannot be analysed.
        """
        if cls.analysis:
            return [resolve_name(cls.analysis)(answers, margin=plan.margins.get(cls.margin_for("")))]
        from tactogram_study.analysis.paired import analyse_means

        return [
            analyse_means(rows, title=cls.title, margin=plan.margins.get(cls.margin_for(question)))
            for question, rows in answers.by("question").items()
        ]

    @classmethod
    def figures(cls, section: AnalysisSection, answers: Answers) -> dict[str, Figure]:
        """Return the figures of a section from `analyse` and its answers, by file name without suffix."""
        means = {f"{section.design}_{section.question}": "tactogram_study.analysis.figures:means_figure"}
        return {name: resolve_name(draw)(section) for name, draw in (cls.drawings or means).items()}

    @classmethod
    def power_method(cls, kind: str) -> PowerMethod:
        """Return the simulation of a power table's studies, by the ``kind`` of its assumptions."""
        from tactogram_study.power import METHODS

        return resolve_name(cls.simulation)() if cls.simulation else METHODS[kind]

    def power_options(self, setting: DesignContext) -> dict[str, Any]:
        """Return options of its power table that follow from the study: ``trials``, ``items``."""
        return {}

    @classmethod
    def simulated_answer(cls, page: Page, question: PageQuestion, participant: SimulatedObserver) -> str:
        """Return a simulated participant's answer to a question of a page.

        By default the right answer with probability `simulated_share`; without right answers from the item's typical
        value, the true effect, the participant's bias and noise.
        """
        if question.right:
            hit = participant.rng.random() < cls.simulated_share(page, participant)
            return question.right if hit else participant.other_option(question, question.right)
        if question.question.kind == "choice":
            return participant.choice(question)
        return "(simulated)" if question.question.kind == "text" else participant.on_scale(question)

    @classmethod
    def simulated_share(cls, page: Page, participant: SimulatedObserver) -> float:
        """Return the probability that a simulated participant is right; by default that of two alternatives."""
        return participant.two_alternatives()


def ab_question(
    identifier: str,
    text: Wording,
    target: Stimulus,
    other: Stimulus | None,
    side: str,
    *,
    scored: bool = True,
) -> PageQuestion:
    """Return a choice between A and B with the target in slot ``side``, which is right if the question is scored."""
    options = (AnswerOption(value="A"), AnswerOption(value="B"))
    return PageQuestion(
        Question(id=identifier, text=text, kind="choice", options=options),
        side=side,
        right=side if scored else "",
        stimulus=target.item,
        condition=target.condition,
        other=other.item if other else "",
        other_condition=other.condition if other else "",
        values={slot: float(slot == side) for slot in "AB"},
    )


def check_standard(name: str, setting: DesignContext) -> None:
    """Raise `ParameterError` if a standard is given and no stimulus has its name."""
    if name and setting.stimulus(name) is None:
        names = ", ".join(stimulus.name for stimulus in setting.stimuli)
        raise ParameterError.must("standard", f"be one of {names}", name)


def pairs_by_item(stimuli: Sequence[Stimulus], first: str, second: str) -> list[tuple[Stimulus, Stimulus]]:
    """Return the stimuli of each item that has both conditions, in the order of the file."""
    versions = {(stimulus.item, stimulus.condition): stimulus for stimulus in stimuli}
    items = dict.fromkeys(stimulus.item for stimulus in stimuli)
    return [
        (versions[item, first], versions[item, second])
        for item in items
        if (item, first) in versions and (item, second) in versions
    ]
