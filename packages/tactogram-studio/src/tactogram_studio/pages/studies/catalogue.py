"""Studies and sessions of a workspace, and the values of the page Studies' forms."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.errors import ParameterError, TactogramError
from tactogram.recipe import parse_changes
from tactogram_studio.pages.studies.experiment_view import participant_count, report_of
from tactogram_studio.workspace.folder import Workspace
from tactogram_study.designs import designs
from tactogram_study.designs.catalogue import margin_text
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
    def line(self) -> str:
        """Design and size, in a line."""
        facts = self.facts
        practice = f", {facts['practice']} of practice" if facts["practice"] else ""
        margins = ", ".join(margin_text(name, value) for name, value in facts["margins"].items())
        if not margins and designs()[facts["design"]].margins:
            margins = "none, so that equivalence cannot be shown"
        return (
            f"{facts['design']}, up to {facts['trials']} trials{practice}, {facts['stimuli']} stimuli; "
            f"order {facts['order']}, {', '.join(facts['languages'])}"
            + (f"; margins: {margins}" if margins else "")
        )


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
        raise ParameterError(
            f"name must be 1 to 40 letters, digits, _ and -, beginning with a letter or digit, got {name[:60]!r}"
        )
    if name.endswith(SIMULATED):
        raise ParameterError(f"name: {SIMULATED} is reserved for simulated participants, got {name!r}")
    folder = Path(SESSIONS) / name
    if workspace.inside(folder).exists():
        raise ParameterError(f"{folder} exists; choose another name, or open the session in the table")
    return folder


def free_session_name(workspace: Workspace, name: str) -> str:
    """Return an unused name for a new session's folder, after the study's name."""
    names = (name if number == 1 else f"{name[:36]}-{number}" for number in range(1, 1000))
    return next(free for free in names if not workspace.inside(Path(SESSIONS) / free).exists())


def analysis_folder(workspace: Workspace, source: Path) -> Path:
    """Return the folder for the analysis of a session or table."""
    if source.is_dir():
        return report_of(source).parent
    return workspace.inside(Path(ANALYSES) / re.sub(r"[^A-Za-z0-9_.-]", "-", workspace.name_of(source)))


def split_commas(text: str | None) -> list[str]:
    """Return the parts of a field between commas, without empty ones."""
    return [part.strip() for part in (text or "").split(",") if part.strip()]


def counts_of(text: str, name: str) -> tuple[int, ...]:
    """Return the whole numbers of a field ``name``, or raise `ParameterError`."""
    try:
        return tuple(int(part) for part in split_commas(text))
    except ValueError:
        raise ParameterError(f"{name} must be whole numbers separated by commas, got {text[:60]!r}") from None


def pairs_of(text: str | None, name: str) -> dict[str, Any]:
    """Return the ``key=value`` pairs of a field ``name``, or raise `ParameterError`."""
    return parse_changes(split_commas(text), option=name)


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
            simulated = any(one["simulated"] for one in progress)
            counts = status_counts(one["status"] for one in progress)
            people = participant_count(len(progress), simulated=simulated)
            title = store.study.title.in_english()
            line = ", ".join(filter(None, (people, counts, "ended" if store.ended else "")))
            line = f"{store.study.name}: {line}"
    except TactogramError as error:
        return SessionEntry(name, error=str(error))
    report = report_of(folder)
    return SessionEntry(name, title, line, simulated, report if report.is_file() else None)
