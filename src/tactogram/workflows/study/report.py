"""An analysis as a page to read and to hand on: one HTML file with all in it."""

from __future__ import annotations

import csv
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from tactogram.evaluation.report import (
    Block,
    ReportFigure,
    ReportSection,
    ReportTable,
    ReportText,
    write_report,
)
from tactogram.study.analysis.findings import AnalysisSection as Said
from tactogram.study.analysis.findings import Finding, number, p_text
from tactogram.study.answers import Answers
from tactogram.study.session.device_facts import COLUMN, fact_description
from tactogram.study.session.side_tables import NOTES, PARTICIPANTS, notes_table, participants_table
from tactogram.study.session.sitting import consent_sha256
from tactogram.study.session.states import status_counts
from tactogram.study.session.store import SessionStore
from tactogram.study.study_analysis import StudyAnalysis
from tactogram.study.study_file import Study

HEADINGS = (
    "of",
    "test",
    "measure",
    "estimate",
    "95 %",
    "p",
    "verdict",
    "within the margin",
    "answers",
    "people",
    "note",
)
SHARED = ("test", "measure", "answers", "people", "note")
"""Said below a table where it is the same in every row."""
EMPTY = "–"
ROLES = {
    "confirmatory": "Confirmatory: what decides",
    "as printed": "As printed: what the publication did",
    "check": "Checks: what stands beside it",
}
OPEN_ROWS = 24
"""Longer tables are folded."""
CAVEATS = (
    "A difference is shown, or not shown. What is not shown is not shown to be absent: a large p says that these "
    "answers do not tell, and the interval says how large the difference may still be.",
    "Equivalent within the margin is said where a test of equivalence (two one-sided tests) shows it, against a "
    "margin. It holds for that margin and no smaller one.",
    "What decides is said per question; where several tests decide, their p answer for their number. Everything else "
    "is a check: of many checks some turn out by chance.",
    "Answers of one person are not independent. Tests that take them as independent stand under As printed or say so.",
)
SIMULATED_PEOPLE = "Simulated participants: programs answered. This says nothing of how anything feels."
SIMULATED_STIMULI = "Simulated stimuli: made by formulas, not recorded from real surfaces."


@dataclass(frozen=True)
class StudyData:
    """Origin of the answers.

    Parameters
    ----------
    source : str
    answers : Answers
    study : Study or None
    participants, notes : (headings, rows)
        As `tactogram.study.session.side_tables` gives them; empty for another's table.
    withdrawn : int or None
        None where it is not known.
    """

    source: str
    answers: Answers
    study: Study | None = None
    participants: tuple[Sequence[str], Sequence[Sequence[str]]] = ((), ())
    notes: tuple[Sequence[str], Sequence[Sequence[str]]] = ((), ())
    withdrawn: int | None = field(default=None)

    @classmethod
    def of(cls, source: Path, answers: Answers, study: Study | None) -> StudyData:
        """Return it of a session folder, or of what was exported beside a table."""
        if source.is_dir():
            with SessionStore(source) as store:
                return cls(
                    source.name,
                    answers,
                    store.study,
                    participants_table(store),
                    notes_table(store),
                    store.withdrawn,
                )
        beside = [_read(source.with_suffix(suffix)) for suffix in (PARTICIPANTS, NOTES)]
        return cls(source.name, answers, study, beside[0], beside[1])


def write_study_report(
    path: Path,
    analysis: StudyAnalysis,
    taken: StudyData,
    figures: Sequence[Mapping[str, Figure]],
    *,
    practice: bool = False,
) -> Path:
    """Write the report of an analysis (beside it, then renamed), and return where it is.

    Parameters
    ----------
    path : Path
    analysis : Analysis
    taken : Taken
    figures : sequence of mapping from str to Figure
        Of each section, as its design's ``figures`` returns them.
    practice : bool
        Whether practice trials were analysed.
    """
    title = analysis.study
    if taken.study is not None:
        title = taken.study.title.en or taken.study.title.ja
    sections = [
        ReportSection(
            "What was found", [*_verdicts(analysis), *(ReportText(line) for line in analysis.plan.lines())]
        )
    ]
    for said, own in zip(analysis.sections, figures, strict=True):
        sections.append(ReportSection(said.title, _blocks(said, list(own.values()))))
    sections += [
        ReportSection("Design", _design(taken)),
        ReportSection("Participants", _participants(taken, analysis)),
    ]
    if taken.notes[1]:
        sections.append(
            ReportSection("Notes of the experimenter", [ReportTable(taken.notes[0], taken.notes[1])])
        )
    caveats = [*CAVEATS, *(f"{note[0].upper()}{note[1:]}." for note in analysis.notes)]
    sections.append(ReportSection("How to read this", [ReportText(line) for line in caveats]))
    about = " Practice trials, which do not count." if practice else ""
    return write_report(
        path,
        title=title,
        summary=_summary(taken, analysis) + about,
        sections=sections,
        simulated=_simulated(taken),
    )


def _summary(taken: StudyData, analysis: StudyAnalysis) -> str:
    people = taken.answers.unique("participant")
    simulated = {row.participant for row in taken.answers if row.simulated}
    who = [f"{len(people) - len(simulated)} participants"] if len(simulated) < len(people) else []
    who += [f"{len(simulated)} simulated participants"] if simulated else []
    answers = sum(said.answers for said in analysis.sections)
    return f"Study {analysis.study}: {answers} answers of {' and '.join(who)}, from {taken.source}."


def _simulated(taken: StudyData) -> str:
    said = [SIMULATED_PEOPLE] if any(taken.answers.column("simulated")) else []
    if any(row.more.get("simulated_stimuli") == "true" for row in taken.answers):
        said.append(SIMULATED_STIMULI)
    return " ".join(said)


def _verdicts(analysis: StudyAnalysis) -> list[Block]:
    """Return what decides, one row per question."""
    rows = [
        [said.title, f.of, f"{f.measure}: {number(f.estimate)}", _interval(f), f.verdict, _who(said)]
        for said in analysis.sections
        for f in said.role("confirmatory")
    ]
    if not rows:
        return [ReportText("No test decides here: too few participants or conditions. See the checks.")]
    header = ("question", "of", "estimate", "95 %", "verdict", "by")
    return [ReportTable(header, rows[:OPEN_ROWS], caption=_more(len(rows)))]


def _blocks(said: Said, figures: Sequence[Figure]) -> list[Block]:
    blocks: list[Block] = [ReportText(f"{said.answers} answers of {_who(said)}.")]
    blocks += [
        ReportFigure(figure, caption=f"{said.title} ({_who(said)}, {said.answers} answers)")
        for figure in figures
    ]
    for role, heading in ROLES.items():
        if held := said.role(role):  # type: ignore[arg-type]
            header, rows, shared = _compact([_row(finding) for finding in held])
            title = f"{heading}. {shared}" if shared else heading
            if role == "check" or len(rows) > OPEN_ROWS:
                blocks.append(ReportTable(header, rows, caption=shared, folded=f"{heading} ({len(rows)})"))
            else:
                blocks.append(ReportTable(header, rows, caption=title))
    for name, table in said.tables.items():
        headings = list(dict.fromkeys(key for row in table for key in row))
        cells = [[row.get(key) for key in headings] for row in table]
        blocks.append(ReportTable(headings, cells, folded=f"{name} ({len(cells)} rows)"))
    return blocks + [ReportText(f"{note[0].upper()}{note[1:]}.") for note in said.notes]


def _row(f: Finding) -> list[object]:
    p = EMPTY if f.p is None else p_text(f.p) + (f" ({f.correction})" if f.correction != "none" else "")
    size = "".join(f"; {name} {number(value)}" for name, value in f.effect.items())
    within = EMPTY
    if f.margin is not None and f.equivalence_p is not None:
        within = f"±{number(f.margin)}: {p_text(f.equivalence_p)}"
    estimate = number(f.estimate) + size
    return [
        f.of,
        f.test,
        f.measure,
        estimate,
        _interval(f),
        p,
        f.verdict or EMPTY,
        within,
        f.n,
        f.participants,
        f.note,
    ]


def _compact(rows: list[list[object]]) -> tuple[list[str], list[list[object]], str]:
    """Return headings and rows without what is empty or the same in every row, and the latter in words."""
    kept, shared = [], []
    for place, heading in enumerate(HEADINGS):
        values = {row[place] for row in rows}
        if values <= {"", EMPTY}:
            continue
        if heading in SHARED and len(values) == 1:
            shared.append(f"{heading}: {values.pop()}")
        else:
            kept.append(place)
    return [HEADINGS[k] for k in kept], [[row[k] for k in kept] for row in rows], "; ".join(shared)


def _interval(f: Finding) -> str:
    return EMPTY if f.low is None or f.high is None else f"{number(f.low)} to {number(f.high)}"


def _who(said: Said) -> str:
    return f"{said.participants} {'simulated ' if said.simulated else ''}participants"


def _design(taken: StudyData) -> list[Block]:
    study = taken.study
    if study is None:
        return [
            ReportText(
                "The table came without its study's file: nothing is known of the design but what its rows say."
            )
        ]
    stimuli = study.all_stimuli
    practice = "none"
    if study.practice:
        practice = f"{study.practice.trials} trials{', with feedback' if study.practice.feedback else ''}"
    facts: list[tuple[str, Any]] = [
        ("name", study.name),
        ("design", study.design.kind),
        ("trials of a participant, at most", str(study.trials)),
        ("stimuli", f"{len(stimuli)}, of which {sum(one.is_simulated for one in stimuli)} simulated"),
        ("conditions", ", ".join(dict.fromkeys(one.condition for one in stimuli if one.condition)) or "one"),
        ("order", f"{study.order}, seed {study.seed}"),
        ("practice", practice),
        ("display", f"{study.display}, played by the {study.played_by}"),
        ("level", study.level),
        ("languages", ", ".join(study.languages)),
        ("reproduces", study.source or EMPTY),
        ("SHA-256 of the study", study.sha256),
        ("SHA-256 of the consent", consent_sha256(study)),
    ]
    text = study.description.en or study.description.ja
    names = [(key, name.en, name.ja) for key, name in study.display_names.items()]
    called = (
        [ReportTable(("key", "en", "ja"), names, folded=f"What is called how ({len(names)})")]
        if names
        else []
    )
    return [*([ReportText(text)] if text else []), ReportTable(("", ""), facts), *called]


def _participants(taken: StudyData, analysis: StudyAnalysis) -> list[Block]:
    headings, rows = taken.participants
    analysed = ", ".join(f"{said.title} {said.participants}" for said in analysis.sections)
    blocks: list[Block] = [ReportText(f"Analysed: {analysed}.")]
    if rows:
        column = list(headings).index("status")
        blocks.append(ReportText(f"Enrolled: {status_counts(row[column] for row in rows)}."))
        blocks.append(
            ReportTable(headings, rows, folded=f"Each participant and what the device said ({len(rows)})")
        )
    if measured := _measured(taken.answers):
        caption = "What devices said with the answers; speeds and rates as measured in the browser."
        blocks.append(
            ReportTable(("", "median", "lowest", "highest", "answers", "people"), measured, caption=caption)
        )
    if taken.withdrawn:
        blocks.append(ReportText(f"{taken.withdrawn} withdrew; nothing of them is kept."))
    return blocks


def _measured(answers: Answers) -> list[list[object]]:
    """Return median and range of each number that devices sent with answers to trials."""
    rows: list[list[object]] = []
    for column in answers.extra_columns:
        if not column.startswith(COLUMN):
            continue
        held = [
            (row.participant, value)
            for row in answers
            if (value := _number(row.more.get(column, ""))) is not None
        ]
        if held:
            values = sorted(value for _, value in held)
            people = len({participant for participant, _ in held})
            named = fact_description(column.removeprefix(COLUMN))
            rows.append([named, statistics.median(values), values[0], values[-1], len(values), people])
    return rows


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _more(count: int) -> str:
    return "" if count <= OPEN_ROWS else f"The first {OPEN_ROWS} of {count}; the others stand below."


def _read(path: Path) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    if not path.is_file():
        return (), ()
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return (rows[0], rows[1:]) if rows else ((), ())
