"""Report of an analysis: one self-contained HTML file."""

from __future__ import annotations

import csv
import math
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from tactogram.evaluation import (
    Block,
    ReportFigure,
    ReportSection,
    ReportTable,
    ReportText,
    write_report,
)
from tactogram_study.analysis.findings import AnalysisSection, Finding, number
from tactogram_study.answers import Answer, Answers
from tactogram_study.session.device_facts import COLUMN, fact_description
from tactogram_study.session.export import NOTES, PARTICIPANTS, notes_table, participants_table
from tactogram_study.session.progress import consent_sha256, status_counts
from tactogram_study.session.store import SessionStore
from tactogram_study.study_analysis import StudyAnalysis, plan_lines
from tactogram_study.study_file import Study

SHARED = ("test", "measure", "answers", "people", "note")
"""Columns that move below the table if all rows agree."""
EMPTY = "–"
ROLES = {
    "confirmatory": "Confirmatory: the deciding tests",
    "as printed": "As printed: tests of the publication",
    "check": "Checks: further evidence",
}
OPEN_ROWS = 24
"""Longer tables are folded."""
CAVEATS = (
    "A difference is either shown or not shown. One that is not shown may still exist: the interval states its "
    "possible size.",
    "Equivalent within the margin means that a test of equivalence (two one-sided tests) shows it, for that margin and "
    "no smaller one.",
    "Each question has deciding tests, with p-values corrected for their number. All other tests are checks: of many "
    "checks some succeed by chance.",
    "Answers of one person are not independent. Tests that assume independence are under As printed or say so.",
)
SIMULATED_PEOPLE = "Simulated participants: programs answered. This does not show how anything feels."
SIMULATED_STIMULI = "Simulated stimuli: computed, not recorded from real surfaces."
PLAYED = {
    "browser": "played by the browser",
    "server": "played by the server",
    "stream": "streamed by the server under the finger",
}


@dataclass(frozen=True)
class StudyData:
    """Answers with their origin; ``participants`` and ``notes`` are headings and rows, empty for a foreign table."""

    source: str
    answers: Answers
    study: Study | None = None
    participants: tuple[Sequence[str], Sequence[Sequence[str]]] = ((), ())
    notes: tuple[Sequence[str], Sequence[Sequence[str]]] = ((), ())
    withdrawn: int | None = field(default=None)

    @classmethod
    def of(cls, source: Path, answers: Answers, study: Study | None) -> StudyData:
        """Return the data of a session folder, or of a table with its exported companions."""
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
        participants, notes = (_read(source.with_suffix(suffix)) for suffix in (PARTICIPANTS, NOTES))
        return cls(source.name, answers, study, participants, notes)


def write_study_report(
    path: Path,
    analysis: StudyAnalysis,
    data: StudyData,
    figures: Sequence[Mapping[str, Figure]],
    *,
    practice: bool = False,
) -> Path:
    """Write the report of an analysis, with the figures of each section's design, and return its path."""
    title = analysis.study
    if data.study is not None:
        title = data.study.title.in_english()
    sections = [
        ReportSection(
            "Findings", [*_verdicts(analysis), *(ReportText(line) for line in plan_lines(analysis.plan))]
        )
    ]
    for section, own in zip(analysis.sections, figures, strict=True):
        sections.append(ReportSection(section.title, _blocks(section, list(own.values()))))
    sections += [
        ReportSection("Design", _design(data)),
        ReportSection("Participants", _participants(data, analysis)),
    ]
    if data.notes[1]:
        sections.append(
            ReportSection("Notes of the experimenter", [ReportTable(data.notes[0], data.notes[1])])
        )
    caveats = [*CAVEATS, *(f"{_sentence(note)}." for note in analysis.notes)]
    sections.append(ReportSection("How to read this", [ReportText(line) for line in caveats]))
    about = " Practice trials, which do not count." if practice else ""
    return write_report(
        path,
        title=title,
        summary=_summary(data, analysis) + about,
        sections=sections,
        simulated=_simulated(data),
    )


def _summary(data: StudyData, analysis: StudyAnalysis) -> str:
    people = data.answers.unique("participant")
    simulated = {row.participant for row in data.answers if row.simulated}
    who = [f"{len(people) - len(simulated)} participants"] if len(simulated) < len(people) else []
    who += [f"{len(simulated)} simulated participants"] if simulated else []
    answers = sum(section.answers for section in analysis.sections)
    return f"Study {analysis.study}: {answers} answers of {' and '.join(who)}, from {data.source}."


def _simulated(data: StudyData) -> str:
    sentences = [SIMULATED_PEOPLE] if any(data.answers.column("simulated")) else []
    if any(map(_about_simulated, data.answers)):
        sentences.append(SIMULATED_STIMULI)
    return " ".join(sentences)


def _about_simulated(row: Answer) -> bool:
    return row.more.get("simulated_stimuli") == "true"


def _verdicts(analysis: StudyAnalysis) -> list[Block]:
    """Return the confirmatory findings, one row per question."""
    rows = [
        [section.title, f.of, f.measure, number(f.estimate), _interval(f), f.verdict, section.participants]
        for section in analysis.sections
        for f in section.role("confirmatory")
    ]
    if not rows:
        return [ReportText("No test decides here: too few participants or conditions. See the checks.")]
    header = ("question", "of", "measure", "estimate", "95 % interval", "verdict", "people")
    return [ReportTable(header, rows[:OPEN_ROWS], caption=_more(len(rows)))]


def _blocks(section: AnalysisSection, figures: Sequence[Figure]) -> list[Block]:
    blocks: list[Block] = [ReportText(f"{section.answers} answers of {_who(section)}.")]
    blocks += [
        ReportFigure(figure, caption=f"{section.title} ({_who(section)}, {section.answers} answers)")
        for figure in figures
    ]
    for role, heading in ROLES.items():
        if held := section.role(role):  # type: ignore[arg-type]
            effects = list(dict.fromkeys(name for finding in held for name in finding.effect))
            header, rows, shared = _compact([_row(finding, effects) for finding in held])
            title = f"{heading}. {shared}" if shared else heading
            if role == "check" or len(rows) > OPEN_ROWS:
                blocks.append(ReportTable(header, rows, caption=shared, folded=f"{heading} ({len(rows)})"))
            else:
                blocks.append(ReportTable(header, rows, caption=title))
    for name, table in section.tables.items():
        headings = list(dict.fromkeys(key for row in table for key in row))
        cells = [[row.get(key) for key in headings] for row in table]
        header = [heading.replace("_", " ") for heading in headings]
        blocks.append(ReportTable(header, cells, folded=f"{_sentence(name)} ({len(cells)} rows)"))
    return blocks + [ReportText(f"{_sentence(note)}.") for note in section.notes]


def _row(f: Finding, effects: Sequence[str]) -> dict[str, object]:
    return {
        "of": f.of,
        "test": f.test,
        "measure": f.measure,
        "estimate": number(f.estimate),
        "95 % interval": _interval(f),
        **{name: number(f.effect[name]) if name in f.effect else EMPTY for name in effects},
        "p": f.p_text().removeprefix("p ").removeprefix("= ") or EMPTY,
        "verdict": f.verdict or EMPTY,
        "within the margin": f.within() or EMPTY,
        "answers": f.n,
        "people": f.participants,
        "note": f.note,
    }


def _compact(rows: list[dict[str, object]]) -> tuple[list[str], list[list[object]], str]:
    """Return headings and rows without empty and shared columns, and the shared values in words."""
    kept, shared = [], []
    for heading in rows[0]:
        values = {row[heading] for row in rows}
        if values <= {"", EMPTY, "all"}:
            continue
        if heading in SHARED and len(values) == 1:
            shared.append(f"{heading}: {values.pop()}")
        else:
            kept.append(heading)
    return kept, [[row[heading] for heading in kept] for row in rows], "; ".join(shared)


def _sentence(text: str) -> str:
    return text[0].upper() + text[1:]


def _interval(f: Finding) -> str:
    return EMPTY if f.low is None or f.high is None else f"{number(f.low)} to {number(f.high)}"


def _who(section: AnalysisSection) -> str:
    return f"{section.participants} {'simulated ' if section.simulated else ''}participants"


def _design(data: StudyData) -> list[Block]:
    study = data.study
    if study is None:
        return [ReportText("The table has no study file: the design is known only from its rows.")]
    stimuli = study.all_stimuli
    practice = "none"
    if study.practice:
        practice = f"{study.practice.trials} trials{', with feedback' if study.practice.feedback else ''}"
    marked = sum(map(_about_simulated, data.answers))
    facts: list[tuple[str, Any]] = [
        ("name", study.name),
        ("design", study.design.kind),
        ("trials of a participant, at most", str(study.trials)),
        ("stimuli", str(len(stimuli))),
        ("answers about simulated stimuli", f"{marked} of {len(data.answers)}"),
        ("conditions", ", ".join(dict.fromkeys(one.condition for one in stimuli if one.condition)) or "one"),
        ("order", f"{study.order}, seed {study.seed}"),
        ("practice", practice),
        ("display", f"{study.display}, {PLAYED[study.played_by]}"),
        ("level", study.level),
        ("languages", ", ".join(study.languages)),
        ("reproduces", study.source or EMPTY),
        ("SHA-256 of the study", study.sha256),
        ("SHA-256 of the consent", consent_sha256(study)),
    ]
    text = study.description.in_english()
    names = [
        (key, *(name.in_language(language) for language in study.languages))
        for key, name in study.display_names.items()
    ]
    called = [ReportTable(("key", *study.languages), names, folded=f"Names ({len(names)})")] if names else []
    return [*([ReportText(text)] if text else []), ReportTable(("fact", "value"), facts), *called]


def _participants(data: StudyData, analysis: StudyAnalysis) -> list[Block]:
    headings, rows = data.participants
    analysed = ", ".join(f"{section.title} {section.participants}" for section in analysis.sections)
    blocks: list[Block] = [ReportText(f"Analysed: {analysed}.")]
    if rows:
        column = list(headings).index("status")
        blocks.append(ReportText(f"Enrolled: {status_counts(row[column] for row in rows)}."))
        blocks.append(ReportTable(headings, rows, folded=f"Participants and device facts ({len(rows)})"))
    if measured := _measured(data.answers):
        caption = "Device facts sent with the answers; speeds and rates as measured in the browser."
        blocks.append(
            ReportTable(
                ("device fact", "median", "lowest", "highest", "answers", "people"), measured, caption=caption
            )
        )
    if data.withdrawn:
        blocks.append(ReportText(f"{data.withdrawn} withdrew; their data is deleted."))
    return blocks


def _measured(answers: Answers) -> list[list[object]]:
    """Return median and range of each number that devices sent with answers."""
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
    return "" if count <= OPEN_ROWS else f"The first {OPEN_ROWS} of {count}; the others are below."


def _read(path: Path) -> tuple[Sequence[str], Sequence[Sequence[str]]]:
    if not path.is_file():
        return (), ()
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    return (rows[0], rows[1:]) if rows else ((), ())
