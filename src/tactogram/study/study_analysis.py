"""A whole study's analysis: which section answers which question."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tactogram.errors import DataError, ParameterError
from tactogram.study import planned as _planned
from tactogram.study.analysis.discrimination import analyse_discrimination
from tactogram.study.analysis.findings import AnalysisSection, with_verdicts
from tactogram.study.answers import Answers
from tactogram.study.designs.evoked.analysis import analyse_evoked
from tactogram.study.designs.magnitude.analysis import analyse_magnitude
from tactogram.study.designs.pairwise.analysis import analyse_preference
from tactogram.study.designs.rating.analysis import Targets, analyse_words
from tactogram.study.designs.staircase.analysis import analyse_staircases
from tactogram.study.designs.two_area.realism import analyse_realism
from tactogram.study.planned import ALPHA, PlannedAnalysis, differing, margin_name, margin_text
from tactogram.study.practice import MARK

WHICH, REALISM = "which", "realism"
MARGINS: tuple[str, ...] = tuple(name for names in _planned.MARGINS.values() for name in names)
"""What a margin can be given for."""
DESIGNS = ("two_area", "rating", "evoked", "abx", "staircase", "magnitude", "pairwise")
UNTESTED = ("questions", MARK)
"""Rows of the questions before and after, and of practice: they are counted, not tested."""


@dataclass(frozen=True)
class AnalysisPlan:
    """What is decided before the answers are seen.

    Parameters
    ----------
    margins : mapping from str to float
        Half the width of what counts as equal, by one of `MARGINS`: a share (``which``, ``abx``), mm (``realism``),
        points (``rating``), dB (``staircase``), the exponent (``magnitude``), the share of words (``evoked``) or
        a difference of log strengths (``preference``).
    targets : mapping, optional
        Scores of the stimuli that ratings are held against.
    reference : str, optional
        Instead: the condition whose mean scores are the targets.
    seed : int
        Of the bootstraps.
    draws : int
        Of a bootstrap; a tenth of it where each draw is a fit.
    alpha : float
        A difference is shown where p is below. Intervals are of 95 % whatever it is.
    planned : Planned, optional
        What the study's file gave beforehand. What differs is reported as given afterwards; without it, nobody can see
        when margins were given, and that is said.

    Raises
    ------
    ParameterError
        If a margin is for something else or not > 0, both targets and a reference are given, or draws are too few.
    """

    margins: Mapping[str, float]
    targets: Targets | None = None
    reference: str | None = None
    seed: int = 0
    draws: int = 2000
    alpha: float = ALPHA
    planned: PlannedAnalysis | None = None

    @classmethod
    def of(
        cls, beforehand: PlannedAnalysis, margins: Mapping[str, float] | None = None, **options: Any
    ) -> AnalysisPlan:
        """Return the plan of a study's file, with margins that were given since in the place of its own."""
        return cls({**beforehand.values, **(margins or {})}, planned=beforehand, **options)

    @property
    def deviations(self) -> dict[str, float]:
        """What is not as the study's file gave it beforehand; {} where nothing is known of that."""
        if self.planned is None:
            return {}
        changed = {} if self.alpha == self.planned.alpha else {"alpha": self.alpha}
        return differing(self.margins, self.planned.values) | changed

    def lines(self) -> list[str]:
        """Return in sentences which margins there are, and when they were given."""
        said = [margin_text(name, value) for name, value in self.margins.items()]
        beforehand = [] if self.planned is None else list(self.planned.margins.items())
        if self.planned is None:
            lines = [
                f"Margins, given with the analysis: {', '.join(said)}. Whether that was beforehand cannot be seen"
            ]
            lines = lines if said else ["No margin was given: nothing can be equivalent"]
        elif beforehand:
            stood = [
                margin_text(name, margin.value) + (f" ({margin.because})" if margin.because else "")
                for name, margin in beforehand
            ]
            lines = [f"Margins, given beforehand in the study's file: {', '.join(stood)}"]
        else:
            lines = ["The study's file gives no margin" + ("" if said else ": nothing can be equivalent")]
        if self.deviations:
            changed = ", ".join(
                f"alpha {value:g}" if name == "alpha" else margin_text(name, value)
                for name, value in self.deviations.items()
            )
            lines.append(
                f"Given afterwards, not as in the study's file: {changed}. What rests on it is exploratory"
            )
        known = "" if self.planned is None or "alpha" in self.deviations else " (beforehand)"
        lines.append(f"Alpha {self.alpha:g}{known}; intervals are of 95 %")
        return [f"{line}." for line in lines]

    def __post_init__(self) -> None:
        for name, margin in self.margins.items():
            if name not in MARGINS:
                raise ParameterError(f"a margin must be for one of {', '.join(MARGINS)}, got {name!r}")
            if not (margin > 0 and np.isfinite(margin)):
                raise ParameterError(f"margin of {name} must be > 0, got {margin:g}")
        if self.targets is not None and self.reference is not None:
            raise ParameterError("ratings are held against targets or a reference condition, got both")
        if not 0 < self.alpha <= 0.2:
            raise ParameterError(f"alpha must be > 0 and at most 0.2, got {self.alpha:g}")
        if self.draws < 100:
            raise ParameterError(f"draws must be at least 100 for an interval of 95 %, got {self.draws}")


@dataclass(frozen=True)
class StudyAnalysis:
    """What is said of a study.

    Parameters
    ----------
    study : str
    sections : tuple of Section
    plan : Plan
    notes : tuple of str
    """

    study: str
    sections: tuple[AnalysisSection, ...]
    plan: AnalysisPlan
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain values, for JSON."""
        return {
            "study": self.study,
            "simulated": any(section.simulated for section in self.sections),
            "margins": dict(self.plan.margins),
            "margins_beforehand": None if self.plan.planned is None else self.plan.planned.values,
            "given_afterwards": self.plan.deviations,
            "alpha": self.plan.alpha,
            "reference": self.plan.reference,
            "seed": self.plan.seed,
            "draws": self.plan.draws,
            "sections": [section.as_dict() for section in self.sections],
            "notes": list(self.notes),
        }

    def text(self) -> str:
        """Return it in lines."""
        head = [
            f"Study {self.study}",
            *self.plan.lines(),
            "A difference is shown or not shown; with a margin what is not shown is equivalent within the margin or "
            "undecided. What is not shown is not shown to be absent.",
            *(f"Note: {note}." for note in self.notes),
        ]
        parts = ["\n".join(head)]
        parts += [f"{'=' * 80}\n{section.text()}" for section in self.sections]
        return "\n\n".join(parts) + "\n"


def analyse(answers: Answers, *, plan: AnalysisPlan | None = None) -> StudyAnalysis:
    """Return the analysis of every question that the answers hold.

    Parameters
    ----------
    answers : Answers
        Of one study; ``design`` says what is asked.
    plan : Plan, optional

    Raises
    ------
    DataError
        If there is no answer to a trial, answers are of several studies, or real and simulated participants are mixed.
    """
    plan = plan or AnalysisPlan({})
    studies = answers.unique("study")
    if len(studies) > 1:
        raise DataError(f"answers must be of one study, got {', '.join(studies)}; analyse them one by one")
    trials = answers.where(lambda row: row.design not in UNTESTED)
    if not len(trials):
        raise DataError("answers must hold trials, got none")
    if len(set(trials.column("simulated"))) > 1:
        raise DataError(
            "answers are of simulated participants and of people: leave one of both out (column simulated)"
        )
    sections = []
    for design, group in trials.by("design").items():
        if design not in DESIGNS:
            raise DataError(f"design must be one of {', '.join(DESIGNS)}, got {design!r}")
        if twice := _twice(group):
            raise DataError(f"{twice}: is there twice; leave one out")
        sections += [_at(section, plan) for section in _sections(design, group, plan)]
    notes: tuple[str, ...] = ()
    if other := len(answers.where(design="questions")):
        notes += (f"{other} answers to the questions before and after the trials are not tested",)
    if practised := len(answers.where(design=MARK)):
        notes += (f"{practised} answers to practice trials are left out",)
    return StudyAnalysis(studies[0], tuple(sections), plan, notes)


def _at(section: AnalysisSection, plan: AnalysisPlan) -> AnalysisSection:
    late = margin_name(section.design, section.question) in plan.deviations
    note = "margin given afterwards" if late else ""
    return with_verdicts(section, alpha=plan.alpha, note=note)


def _sections(design: str, group: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
    rng = np.random.default_rng(plan.seed)
    fits = max(100, plan.draws // 10)
    margin = plan.margins.get
    if design == "two_area":
        return _two_area(group, plan)
    single: dict[str, Callable[[], AnalysisSection]] = {
        "rating": lambda: analyse_words(
            group,
            rng=rng,
            targets=plan.targets,
            reference=plan.reference,
            margin=margin("rating"),
            draws=plan.draws,
        ),
        "evoked": lambda: analyse_evoked(group, margin=margin("evoked")),
        "abx": lambda: analyse_discrimination(group, margin=margin("abx"), design="abx"),
        "staircase": lambda: analyse_staircases(group, rng=rng, margin=margin("staircase"), draws=fits),
        "magnitude": lambda: analyse_magnitude(group, margin=margin("magnitude")),
        "pairwise": lambda: analyse_preference(group, margin=margin("preference")),
    }
    return [single[design]()]


def _two_area(group: Answers, plan: AnalysisPlan) -> list[AnalysisSection]:
    found = []
    for question, rows in group.by("question").items():
        if question == WHICH:
            found.append(analyse_discrimination(rows, margin=plan.margins.get("which")))
        elif question == REALISM:
            found.append(analyse_realism(rows, margin=plan.margins.get("realism")))
        else:
            raise DataError(f"two_area: question must be {WHICH} or {REALISM}, got {question!r}")
    return found


def _twice(group: Answers) -> str:
    """Return the first answer that stands there twice, in words; "" where none does."""
    seen = set()
    for row in group:
        key = (row.participant, row.session, row.trial, row.question, row.stimulus, row.condition, row.repeat)
        if row.trial and key in seen:
            return f"trial {row.trial} of participant {row.participant}, question {row.question}"
        seen.add(key)
    return ""
