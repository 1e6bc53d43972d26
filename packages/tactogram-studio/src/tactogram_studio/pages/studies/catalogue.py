"""Studies and sessions of a workspace, and the forms to begin, plan and analyse one."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

from nicegui import app, ui

from tactogram.errors import ParameterError, TactogramError
from tactogram.parameters import parameters
from tactogram.recipe import parse_changes
from tactogram_studio import kit
from tactogram_studio.context import Studio
from tactogram_studio.workspace.commands import free_name
from tactogram_studio.workspace.folder import RUN, STORE, Workspace
from tactogram_studio.workspace.session_view import address_of, participant_count, report_of
from tactogram_study.answers import SUFFIXES
from tactogram_study.designs import designs
from tactogram_study.designs.catalogue import margin_text, power_tables
from tactogram_study.session.progress import status_counts
from tactogram_study.session.store import SessionStore
from tactogram_study.study_file import shipped_studies
from tactogram_study.workflows.sessions import SIMULATED
from tactogram_study.workflows.studies import check_study

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
SESSIONS, ANALYSES = "sessions", "studio/analyses"
"""Folders of the workspace for new sessions and analyses."""
HEADINGS: Mapping[str, str] = {
    "trials": "trials each",
    "power": "shows the effect",
    "type_1": "false positive",
    "equivalence": "shows equivalence",
    "threshold_error_db": "threshold error, dB",
}
"""Headings of a power table, by column."""
SIMULATIONS = 2000


@dataclass(frozen=True)
class StudyEntry:
    """A study: a shipped one by name, or a file by its path relative to the workspace.

    ``source`` is for `begin_session`, ``facts`` are from `check_study`; an invalid study has an ``error`` and no facts.
    """

    name: str
    source: Path | str
    shipped: bool
    facts: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""

    @property
    def title(self) -> str:
        """Title, or name."""
        return str(self.facts.get("title") or self.name)

    @property
    def question_text(self) -> str:
        """The research question, in a sentence."""
        design = designs().get(str(self.facts.get("design")))
        return design.question_text if design else ""

    @property
    def size(self) -> str:
        """Numbers of trials and stimuli, in a line."""
        facts = self.facts
        practice = f" after {facts['practice']} of practice" if facts["practice"] else ""
        return f"Up to {facts['trials']} trials{practice}, {facts['stimuli']} stimuli"

    @property
    def details(self) -> list[str]:
        """Design, order, languages, margins and source, in lines."""
        facts = self.facts
        margins = ", ".join(margin_text(name, value) for name, value in facts["margins"].items())
        if not margins and designs()[facts["design"]].margins:
            margins = "none, so that equivalence cannot be shown"
        return [
            f"{self.name}: design {facts['design']}, order {facts['order']}",
            f"Languages: {', '.join(facts['languages'])}",
            *([f"Margins: {margins}"] if margins else []),
            *([f"Reproduces: {facts['source']}"] if facts["source"] else []),
        ]


@dataclass(frozen=True)
class SessionEntry:
    """A session by its folder relative to the workspace; ``error`` is why it cannot be opened."""

    name: str
    title: str = ""
    line: str = ""
    simulated: bool = False
    report: Path | None = None
    error: str = ""


def workspace_studies(workspace: Workspace) -> list[StudyEntry]:
    """Return the shipped studies and those of the workspace, checked, each once."""
    shipped = shipped_studies()
    own = {path.resolve() for path in workspace.studies()} - {path.resolve() for path in shipped.values()}
    entries = [_study_entry(name, name, shipped=True) for name in shipped]
    return entries + [_study_entry(workspace.name_of(path), path, shipped=False) for path in sorted(own)]


def workspace_sessions(workspace: Workspace) -> list[SessionEntry]:
    """Return the sessions of the workspace, newest first."""
    return [_session_entry(workspace, folder) for folder in workspace.sessions()]


def new_session_folder(workspace: Workspace, name: str) -> Path:
    """Return the folder of a new session, relative to the workspace; `ParameterError` for an invalid or taken name."""
    name = name.strip()
    if not NAME.fullmatch(name):
        raise ParameterError.must(
            "name", "be 1 to 40 letters, digits, _ and -, beginning with a letter or digit", name[:60]
        )
    if name.endswith(SIMULATED):
        raise ParameterError(f"name: {SIMULATED} is reserved for simulated participants, got {name!r}")
    folder = Path(SESSIONS) / name
    if workspace.inside(folder).exists():
        raise ParameterError(f"{folder} exists; choose another name, or open the session in the table")
    return folder


def analysis_folder(workspace: Workspace, source: Path) -> Path:
    """Return the folder for the analysis of a session or table."""
    if source.is_dir():
        return report_of(source).parent
    return workspace.inside(Path(ANALYSES) / re.sub(r"[^A-Za-z0-9_.-]", "-", workspace.name_of(source)))


def pairs_of(text: str | None, name: str) -> dict[str, Any]:
    """Return the ``key=value`` pairs of a field ``name``, or raise `ParameterError`."""
    return parse_changes([part for part in (text or "").split(",") if part.strip()], option=name)


def power_rows(rows: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[list[str]]]:
    """Return headings and cells of a power table."""
    cells = [
        [f"{value:.2f}" if isinstance(value, float) else str(value) for value in row.values()] for row in rows
    ]
    return [HEADINGS.get(name, name.replace("_", " ")) for name in rows[0]], cells


def _study_entry(name: str, source: Path | str, *, shipped: bool) -> StudyEntry:
    try:
        return StudyEntry(name, source, shipped, check_study(source))
    except TactogramError as error:
        return StudyEntry(name, source, shipped, error=str(error))


def _session_entry(workspace: Workspace, folder: Path) -> SessionEntry:
    name = workspace.name_of(folder)
    try:
        with SessionStore(folder) as store:
            progress = store.progress()
            simulated = any(participant["simulated"] for participant in progress)
            counts = status_counts(participant["status"] for participant in progress)
            people = participant_count(len(progress), simulated=simulated)
            title = store.study.title.in_english()
            line = ", ".join(filter(None, (people, counts, "ended" if store.ended else "")))
            line = f"{store.study.name}: {line}"
    except TactogramError as error:
        return SessionEntry(name, error=str(error))
    report = report_of(folder)
    return SessionEntry(name, title, line, simulated, report if report.is_file() else None)


def begin_dialog(studio: Studio, source: Path | str, *, title: str, name: str) -> None:
    """Ask for the session's folder, begin a session of a study file or shipped study, and open its page."""

    async def begin() -> None:
        session_folder = new_session_folder(studio.workspace, folder.value or "")
        values = pairs_of(changes.value, "Changes")
        with kit.busy("beginning the session"):
            await kit.in_background(studio.sessions.begin, source, session_folder, changes=values)
        ui.navigate.to(address_of(session_folder.as_posix()))

    with kit.form_dialog(f"Begin a session: {title}", "Begin", begin, label="Begin a session"):
        free = free_name(studio.workspace.inside(SESSIONS), name[:36])
        folder = ui.input("Name of the session's folder", value=free)
        folder.classes("w-full")
        changes = ui.input("Changes (optional)").props('placeholder="design.repeats=2, seed=7"')
        changes.classes("w-full")
        kit.hint("Answers are stored in this folder. The study cannot be changed once the session has begun.")


def power() -> None:
    """Draw the form and table of statistical power."""
    from tactogram_study.workflows.power import study_power

    with kit.card("Before a study: statistical power", classes="w-full stack"):
        kit.hint(
            f"Each row simulates {SIMULATIONS} studies with simulated participants. Empty fields have typical values; "
            "enter those of a pilot."
        )
        with ui.row().classes("items-end gap-4"):
            tables = list(power_tables())
            state = kit.TabSettings(app.storage.user.setdefault("power", {}))
            design = kit.Form(state, classes="w-36").choice("design", tables, "Design")
            fields = kit.ParameterFields(
                parameters(study_power),
                ("participants", "trials", "effect", "margin"),
                labels={"trials": "Trials each"},
                examples={"participants": "10,20", "trials": "30,90"},
                entries=state,
            )
            button = ui.button("Calculate power")
        shown = ui.column().classes("w-full gap-2").props('aria-live="polite"')

        async def calculate() -> None:
            with kit.busy("simulating studies", button=button):
                result = await kit.in_background(
                    study_power, design.value, **fields.values(), simulations=SIMULATIONS
                )
            shown.clear()
            with shown:
                caption = f"Design {result['design']}: share of simulated studies with each result"
                kit.table(*power_rows(result["rows"]), caption=caption)
                with (
                    ui.expansion("Full report with assumptions").classes("w-full"),
                    ui.element("div").classes("power"),
                ):
                    ui.element("pre")._text = result["text"]

        button.on_click(calculate)
        design.on_value_change(shown.clear)


def analysis(workspace: Workspace, sessions: list[SessionEntry]) -> None:
    """Draw the form that analyses a session or a table of answers."""
    from tactogram_study.workflows.analysis import analyse_study

    with kit.card("After a study: analysis", classes="w-full stack"):
        kit.hint(
            "The publication's test and a sound one, with intervals and verdicts; margins are those of the study's "
            "file. Tables of other programs are read by their headings."
        )
        tables = [
            workspace.name_of(path) for path in workspace.user_files(*SUFFIXES) if _may_be_answers(path)
        ]
        sources = {
            session.name: f"session {session.name}{' (simulated)' if session.simulated else ''}"
            for session in sessions
        }
        sources |= {name: f"table {name}" for name in tables}
        if not sources:
            ui.label("No sessions or tables (.csv, .tsv, .parquet) in this workspace yet.").classes("quiet")
            return
        state = kit.TabSettings(app.storage.user.setdefault("analysis", {}))
        if state.get("source") not in sources:  # it is unknown which tables hold answers
            state["source"] = sessions[0].name if sessions else None
        source = ui.select(sources, label="Answers", with_input=True).classes("w-96")
        source.bind_value(state, "source")
        with (
            ui.expansion("Tables of other programs, other margins").classes("w-full"),
            ui.row().classes("items-end gap-4"),
        ):
            fields = kit.ParameterFields(
                parameters(analyse_study),
                ("design", "columns", "constants", "margins"),
                labels={
                    "design": "Design of the table",
                    "columns": "Names of columns in the table",
                    "constants": "Values that are the same in every row",
                    "margins": "Other margins",
                },
                examples={
                    "design": next(iter(designs())),
                    "columns": "participant=subject",
                    "constants": "question=which",
                    "margins": "which=0.1",
                },
                entries=state,
                classes="",
            )
        button = ui.button("Analyse")
        shown = ui.column().classes("w-full gap-1").props('aria-live="polite"')

        async def analyse() -> None:
            if not source.value:
                raise ParameterError("choose the answers first: a session or a table")
            chosen = workspace.inside(source.value)
            out = analysis_folder(workspace, chosen)
            with kit.busy("analysing the answers", button=button), workspace.readable_errors():
                result = await kit.in_background(analyse_study, chosen, out, **fields.values())
            shown.clear()
            with shown:
                for note in result["notes"]:
                    ui.label(note)
                for section in result["sections"]:
                    who = participant_count(section["participants"], simulated=section["simulated"])
                    for finding in section["findings"]:
                        if finding["role"] == "confirmatory":
                            text = finding["verdict"] or f"{finding['measure']} {finding['estimate']:.3g}"
                            ui.label(f"{section['title']}, {finding['of']}: {text} ({who})")
                ui.link("Open the report", f"/reports?of={quote(workspace.name_of(out / 'report.html'))}")

        button.on_click(analyse)
        source.on_value_change(shown.clear)


def _may_be_answers(path: Path) -> bool:
    """Return whether a table may hold answers: it does not belong to a session's export, a store or a run."""
    if path.name.endswith((".participants.csv", ".notes.csv")):
        return False
    if any((path.parent / name).is_file() for name in (STORE, RUN)):
        return False
    return not any(parent.name in ("beh", "sourcedata") for parent in path.parents)
