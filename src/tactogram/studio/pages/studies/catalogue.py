"""Studies that can be begun and sessions that were, as the page of studies lists them: no page in it."""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal.io.atomic import atomic_write
from tactogram.studio.pages.studies.experiment_view import report_of
from tactogram.studio.workspace.folder import Workspace
from tactogram.study.designs import designs
from tactogram.study.designs.catalogue import margin_text
from tactogram.study.session.states import status_counts
from tactogram.study.session.store import SessionStore
from tactogram.study.study_file import shipped_studies
from tactogram.workflows.study.simulation import SIMULATED
from tactogram.workflows.study.studies import check_study

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
SESSIONS, STUDIES, ANALYSES = "sessions", "studies", "studio/analyses"
"""Folders of the workspace for what is begun, copied and analysed from the page."""


@dataclass(frozen=True)
class StudyEntry:
    """A study that can be begun.

    Parameters
    ----------
    name : str
        Of a shipped one, or a file's path relative to the workspace.
    source : Path or str
        As `tactogram.workflows.study.sessions.begin_session` takes it.
    shipped : bool
    facts : mapping
        What `check_study` returned; empty where it is wrong.
    wrong : str
    """

    name: str
    source: Path | str
    shipped: bool
    facts: Mapping[str, Any] = field(default_factory=dict)
    wrong: str = ""

    @property
    def title(self) -> str:
        """Its title, or its name where it has none."""
        return str(self.facts.get("title") or self.name)

    @property
    def question_text(self) -> str:
        """What is asked, in a sentence."""
        design = designs().get(str(self.facts.get("design")))
        return design.question_text if design else ""

    @property
    def line(self) -> str:
        """How large it is, in a line."""
        facts = self.facts
        practice = f", {facts['practice']} of practice" if facts["practice"] else ""
        margins = ", ".join(margin_text(name, value) for name, value in facts["margins"].items())
        if not margins and designs()[facts["design"]].margins:
            margins = "none, so that nothing can be shown to be equivalent"
        return (
            f"{facts['design']}, up to {facts['trials']} trials{practice}, {facts['stimuli']} stimuli; "
            f"order {facts['order']}, {', '.join(facts['languages'])}"
            + (f"; margins: {margins}" if margins else "")
        )


@dataclass(frozen=True)
class SessionEntry:
    """A session of the workspace.

    Parameters
    ----------
    name : str
        Its folder, relative to the workspace.
    title, line : str
    simulated : bool
        Whether simulated participants took it.
    report : Path or None
    wrong : str
        Why it cannot be opened, if it cannot.
    """

    name: str
    title: str = ""
    line: str = ""
    simulated: bool = False
    report: Path | None = None
    wrong: str = ""


def workspace_studies(workspace: Workspace) -> list[StudyEntry]:
    """Return the shipped studies and those of the workspace, each checked; once, also where it holds the package."""
    shipped = shipped_studies()
    own = sorted(
        {path.resolve() for path in workspace.studies()} - {path.resolve() for path in shipped.values()}
    )
    found = [_listed(name, name, shipped=True) for name in shipped]
    return found + [_listed(workspace.name_of(path), path, shipped=False) for path in own]


def begun(workspace: Workspace) -> list[SessionEntry]:
    """Return the sessions of the workspace, newest first."""
    return [_begun(workspace, folder) for folder in workspace.sessions()]


def session_folder(workspace: Workspace, name: str) -> Path:
    """Return a new folder for a session, relative to the workspace.

    Raises
    ------
    ParameterError
        If the name is none for a folder, or is taken.
    """
    checked = _name(name)
    if checked.endswith(SIMULATED):
        raise ParameterError(
            f"name: {SIMULATED} at the end stands for simulated participants, got {checked!r}"
        )
    folder = Path(SESSIONS) / checked
    if workspace.inside(folder).exists():
        raise ParameterError(f"{folder} is there already; give another name, or go on with it below")
    return folder


def copy_study(workspace: Workspace, name: str) -> Path:
    """Copy a shipped study into the workspace, to be changed, and return the file.

    Raises
    ------
    DataError
        If there is a file of that name.
    """
    target = workspace.inside(Path(STUDIES) / f"{name}.toml")
    if target.exists():
        raise DataError(f"{workspace.name_of(target)} is there already; change that one, or move it away")
    target.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(target) as part:
        shutil.copyfile(shipped_studies()[name], part)
    return target


def analysis_folder(workspace: Workspace, source: Path) -> Path:
    """Return where the analysis of a session or table is written."""
    if source.is_dir():
        return report_of(source).parent
    return workspace.inside(Path(ANALYSES) / re.sub(r"[^A-Za-z0-9_.-]", "-", workspace.name_of(source)))


def counts_of(text: str, what: str) -> tuple[int, ...]:
    """Return whole numbers separated by commas; () of an empty text.

    Raises
    ------
    ParameterError
        If one is none.
    """
    try:
        return tuple(int(part) for part in text.split(",") if part.strip())
    except ValueError:
        raise ParameterError(f"{what} must be whole numbers separated by commas, got {text[:60]!r}") from None


def pairs_of(text: str, what: str) -> dict[str, str]:
    """Return ``name=value`` pairs separated by commas; {} of an empty text.

    Raises
    ------
    ParameterError
        If one is none.
    """
    found = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, sign, value = part.partition("=")
        if not sign or not name.strip() or not value.strip():
            raise ParameterError(f"{what} must be name=value, separated by commas, got {part[:60]!r}")
        found[name.strip()] = value.strip()
    return found


def power_rows(rows: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[list[str]]]:
    """Return the headings and cells of a power table for people; what is exact for independent answers is left out."""
    kept = [name for name in rows[0] if not name.startswith("exact_")]
    cells = [
        [f"{row[name]:.2f}" if isinstance(row[name], float) else str(row[name]) for name in kept]
        for row in rows
    ]
    return [HEADINGS.get(name, name.replace("_", " ")) for name in kept], cells


HEADINGS: Mapping[str, str] = {
    "trials": "trials of each",
    "power": "shows the effect",
    "type_1": "shows what is not there",
    "equivalence": "shows equivalence",
    "printed_power": "publication's test: effect",
    "printed_type_1": "publication's test: what is not there",
    "threshold_error_db": "error of a threshold, dB",
}


def _listed(name: str, source: Path | str, *, shipped: bool) -> StudyEntry:
    try:
        return StudyEntry(name, source, shipped, check_study(source))
    except TactogramError as error:
        return StudyEntry(name, source, shipped, wrong=str(error))


def _begun(workspace: Workspace, folder: Path) -> SessionEntry:
    name = workspace.name_of(folder)
    try:
        with SessionStore(folder) as store:
            progress = store.progress()
            simulated = any(one["simulated"] for one in progress)
            stand = status_counts(one["status"] for one in progress)
            who = f"{len(progress)} {'simulated ' if simulated else ''}participant{'' if len(progress) == 1 else 's'}"
            title = store.study.title.en or store.study.title.ja
            line = (
                f"{store.study.name}: {who}{f', {stand}' if stand else ''}{', ended' if store.ended else ''}"
            )
    except TactogramError as error:
        return SessionEntry(name, wrong=str(error))
    report = report_of(folder)
    return SessionEntry(name, title, line, simulated, report if report.is_file() else None)


def _name(text: str) -> str:
    if not NAME.fullmatch(text.strip()):
        raise ParameterError(
            f"name must be 1 to 40 letters, digits, _ and -, beginning with a letter or digit, got {text[:60]!r}"
        )
    return text.strip()
