"""Reports of a workspace, and published figures next to ours."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from tactogram.errors import DataError, ParameterError
from tactogram.text_files import read_json
from tactogram_studio.workspace.folder import RUN, SESSION, Workspace

Kind = Literal["report", "numbers", "figure", "text"]

KINDS: Mapping[str, Kind] = {
    ".html": "report",
    ".json": "numbers",
    ".png": "figure",
    ".svg": "figure",
    ".txt": "text",
}
NUMBERS = ("evaluation.json", "crossval.json", "analysis.json", "result.json", "mixing.json")
TEXTS = ("analysis.txt",)
MOST_BYTES = 50_000_000
MOST_LISTED = 400


@dataclass(frozen=True)
class ReportFile:
    """A file of a run, session or analysis (``folder``); both paths are relative to the workspace.

    ``simulated`` refers to the reported data; ``changed`` is in seconds since 1970.
    """

    path: str
    kind: Kind
    folder: str
    simulated: bool
    changed: float


def report_files(workspace: Workspace) -> list[ReportFile]:
    """Return the files of all reports, newest folder first; reports before numbers before figures."""
    hidden = [workspace.studio_folder / name for name in ("kept", "sent", "state", "uploads")]
    files: list[ReportFile] = []
    simulated: dict[Path, bool | None] = {}
    for path in workspace.files(*KINDS):
        kind = KINDS[path.suffix.lower()]
        if any(path.is_relative_to(folder) for folder in hidden):
            continue
        if (kind == "numbers" and path.name not in NUMBERS) or (kind == "text" and path.name not in TEXTS):
            continue
        folder = path.parent.parent if path.parent.name == "figures" else path.parent
        if folder not in simulated:
            simulated[folder] = is_simulated(folder) if _has_results(folder) else None
        is_folder_simulated = simulated[folder]
        if is_folder_simulated is None:
            continue
        try:
            changed = path.stat().st_mtime
        except OSError:  # just deleted
            continue
        name = workspace.name_of(folder) if folder != workspace.folder else "."
        files.append(ReportFile(workspace.name_of(path), kind, name, is_folder_simulated, changed))
    newest: dict[str, float] = {}
    for file in files:
        newest[file.folder] = max(newest.get(file.folder, 0.0), file.changed)
    order = list(dict.fromkeys(KINDS.values()))
    files.sort(key=lambda file: (-newest[file.folder], file.folder, order.index(file.kind), file.path))
    return files[:MOST_LISTED]


def _has_results(folder: Path) -> bool:
    """Return whether a folder is a run, session or analysis, or holds a report; figures alone do not count."""
    return any((folder / name).is_file() for name in (RUN, SESSION, "report.html", *NUMBERS))


def in_scheme(report: bytes, scheme: Literal["light", "dark"]) -> bytes:
    """Return a report as HTML that is light or dark, whatever the system is."""
    media = b"@media all" if scheme == "dark" else b"@media not all"
    return report.replace(b"@media (prefers-color-scheme: dark)", media).replace(
        b"color-scheme: light dark", f"color-scheme: {scheme}".encode()
    )


def is_simulated(folder: Path) -> bool:
    """Return whether a run's data or the numbers in a folder are marked as simulated."""
    for name in ("data.json", *NUMBERS):
        with suppress(DataError):
            if marked_simulated(read_json(folder / name)):
                return True
    return False


def marked_simulated(values: Any) -> bool:
    """Return whether a result marks its data, devices or participants as simulated."""
    if not isinstance(values, Mapping):
        return False
    if values.get("simulated") or "simulated" in str(values.get("name", "")):
        return True
    data = values.get("data")
    return marked_simulated(data) if isinstance(data, Mapping) else "simulated" in str(data or "")


def readable_file(workspace: Workspace, name: str) -> Path:
    """Return a file to show.

    Raises `DataError` or `ParameterError` if it is outside the workspace, missing, of another kind, or too large.
    """
    path = workspace.inside(name)
    if path.suffix.lower() not in KINDS or path.is_relative_to(workspace.studio_folder / "state"):
        raise ParameterError(f"{name[:200]}: only {', '.join(KINDS)} files can be shown here")
    if not path.is_file():
        raise DataError(f"{name[:200]}: no such file in the workspace")
    if path.stat().st_size > MOST_BYTES:
        raise DataError(f"{name[:200]}: larger than {MOST_BYTES // 10**6} MB; open it with another program")
    return path


def matching(words: str, texts: Iterable[str]) -> bool:
    """Return whether the texts contain every word, ignoring case."""
    whole = " ".join(texts).lower()
    return all(word in whole for word in words.lower().split())


def published_cells(rows: Sequence[Mapping[str, Any]], words: str = "") -> list[dict[str, str]]:
    """Return the rows of `tactogram.workflows.results_table.table` with all ``words`` as texts by column."""
    return [
        _cells(row) | {"id": str(number)}
        for number, row in enumerate(rows)
        if matching(words, (str(value) for value in row.values()))
    ]


def _cells(row: Mapping[str, Any]) -> dict[str, str]:
    published, ours, sd = row["published"], row["ours"], row["sd"]
    known = published is not None and ours is not None
    return {
        "Model": row["model"],
        "Result": row["what"],
        "Published": f"{_number(published)}\n{row['where']}",
        "Ours": _number(ours) + (f" ± {sd:g}" if ours is not None and sd is not None else ""),
        "Difference": f"{ours - published:+.3g}" if known else "",
        "Seeds": "" if ours is None else str(row["seeds"]),
        "Data and split": f"{row['data'] or 'not measured'}\n{row['split']}",
        "Reason for the difference": str(row["note"]),
    }


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"
