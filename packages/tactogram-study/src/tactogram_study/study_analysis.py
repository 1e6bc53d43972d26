"""Analysis of a whole study: a section for each question."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram_study.analysis.findings import AnalysisSection, with_verdicts
from tactogram_study.answers import Answers
from tactogram_study.designs import designs
from tactogram_study.designs.catalogue import margin_scales, margin_text
from tactogram_study.planned import AnalysisPlan
from tactogram_study.practice import MARK

UNTESTED = ("questions", MARK)
"""Designs of rows that are counted, not tested: the questions before and after, and practice."""


@dataclass(frozen=True)
class StudyAnalysis:
    """Analysis of a study."""

    study: str
    sections: tuple[AnalysisSection, ...]
    plan: AnalysisPlan
    notes: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return plain values for JSON."""
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
        """Return the analysis in lines."""
        head = [
            f"Study {self.study}",
            *plan_lines(self.plan),
            "A difference is shown or not shown; with a margin what is not shown is equivalent within the margin or "
            "undecided. What is not shown is not shown to be absent.",
            *(f"Note: {note}." for note in self.notes),
        ]
        parts = ["\n".join(head)]
        parts += [f"{'=' * 80}\n{section.text()}" for section in self.sections]
        return "\n\n".join(parts) + "\n"


def plan_lines(plan: AnalysisPlan) -> list[str]:
    """Return sentences on the margins, and on when they were set."""
    texts = [margin_text(name, value) for name, value in plan.margins.items()]
    if plan.planned is None:
        lines = [
            f"Margins, given with the analysis: {', '.join(texts)}. Whether that was beforehand cannot be seen"
        ]
        lines = lines if texts else ["No margin was given: nothing can be equivalent"]
    elif plan.planned.margins:
        planned = [
            margin_text(name, margin.value) + (f" ({margin.because})" if margin.because else "")
            for name, margin in plan.planned.margins.items()
        ]
        lines = [f"Margins, given beforehand in the study's file: {', '.join(planned)}"]
    else:
        lines = ["The study's file gives no margin" + ("" if texts else ": nothing can be equivalent")]
    if plan.deviations:
        changed = ", ".join(
            f"alpha {value:g}" if name == "alpha" else margin_text(name, value)
            for name, value in plan.deviations.items()
        )
        lines.append(
            f"Given afterwards, not as in the study's file: {changed}. What rests on it is exploratory"
        )
    timing = "" if plan.planned is None or "alpha" in plan.deviations else " (beforehand)"
    lines.append(f"Alpha {plan.alpha:g}{timing}; intervals are of 95 %")
    return [f"{line}." for line in lines]


def analyse(answers: Answers, *, plan: AnalysisPlan | None = None) -> StudyAnalysis:
    """Return the analysis of every question in the answers to one study.

    Raises `ParameterError` for a margin that no design has; `DataError` if there is no answer to a trial, answers are
    of several studies, or people and simulated participants are mixed.
    """
    plan = plan or AnalysisPlan({})
    scales = margin_scales()
    if unknown := next((name for name in plan.margins if name not in scales), None):
        raise ParameterError(f"a margin must be for one of {', '.join(scales)}, got {unknown!r}")
    studies = answers.unique("study")
    if len(studies) > 1:
        raise DataError(f"answers must be of one study, got {', '.join(studies)}; analyse them one by one")
    trials = answers.where(lambda row: row.design not in UNTESTED)
    if not len(trials):
        raise DataError("answers must hold trials, got none")
    if len(set(trials.column("simulated"))) > 1:
        raise DataError(
            "answers are of simulated participants and of people: remove either (column simulated)"
        )
    sections = []
    for kind, group in trials.by("design").items():
        if kind not in designs():
            raise DataError(f"design must be one of {', '.join(designs())}, got {kind!r}")
        if twice := _duplicate(group):
            raise DataError(twice, "appears twice; remove one")
        for section in designs()[kind].analyse(group, plan):
            changed = designs()[kind].margin_for(section.question) in plan.deviations
            note = "margin given afterwards" if changed else ""
            sections.append(with_verdicts(section, alpha=plan.alpha, note=note))
    notes: tuple[str, ...] = ()
    if other := len(answers.where(design="questions")):
        notes += (f"{other} answers to the questions before and after the trials are not tested",)
    if practised := len(answers.where(design=MARK)):
        notes += (f"{practised} answers to practice trials are left out",)
    return StudyAnalysis(studies[0], tuple(sections), plan, notes)


def _duplicate(group: Answers) -> str:
    """Return a description of the first duplicate answer, "" if there is none."""
    seen = set()
    for row in group:
        key = (row.participant, row.session, row.trial, row.question, row.stimulus, row.condition, row.repeat)
        if row.trial and key in seen:
            return f"trial {row.trial} of participant {row.participant}, question {row.question}"
        seen.add(key)
    return ""
