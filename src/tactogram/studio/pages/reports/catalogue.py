"""Catalogue of reports, their figures, published figures beside ours, and experiments.

Pure functions; the HTML that they give is escaped.
"""

from __future__ import annotations

import html
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import tactogram
from tactogram.errors import DataError, ParameterError
from tactogram.experiments.catalogue import PUBLISHED, experiments
from tactogram.studio.workspace.folder import RUN, SESSION, Workspace

Kind = Literal["report", "numbers", "figure", "text"]

KINDS: Mapping[str, Kind] = {
    ".html": "report",
    ".json": "numbers",
    ".png": "figure",
    ".svg": "figure",
    ".txt": "text",
}
MEDIA = {
    ".html": "text/html; charset=utf-8",
    ".json": "application/json",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
}
NUMBERS = ("evaluation.json", "crossval.json", "analysis.json", "result.json", "mixing.json")
TEXTS = ("analysis.txt",)
MOST_BYTES = 50_000_000
MOST_LISTED = 400
BENCHMARKS = Path(tactogram.__file__).parents[2] / "benchmarks"
"""Beside the source: experiments of our own, and committed results; not there where only the package is installed."""
COMMANDS = {PUBLISHED: "tactogram reproduce", BENCHMARKS / "experiments": "python -m benchmarks"}
"""Folders of experiments, and what runs one."""


@dataclass(frozen=True)
class ReportFile:
    """A file to be read.

    Parameters
    ----------
    path : str
        Relative to the workspace.
    kind : {"report", "numbers", "figure", "text"}
    folder : str
        Relative to the workspace: what it is of.
    simulated : bool
        Whether what it reports is simulated.
    changed : float
        Seconds since 1970.
    """

    path: str
    kind: Kind
    folder: str
    simulated: bool
    changed: float

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.rsplit("/", 1)[-1]


def readables(workspace: Workspace) -> list[ReportFile]:
    """Return what can be read, newest folder first; reports before numbers before figures."""
    hidden = [workspace.own / name for name in ("kept", "sent", "state", "uploads")]
    found: list[ReportFile] = []
    simulated: dict[Path, bool] = {}
    of_something: dict[Path, bool] = {}
    for path in workspace.files(*KINDS):
        kind = KINDS[path.suffix.lower()]
        if any(path.is_relative_to(folder) for folder in hidden):
            continue
        if (kind == "numbers" and path.name not in NUMBERS) or (kind == "text" and path.name not in TEXTS):
            continue
        folder = path.parent.parent if path.parent.name == "figures" else path.parent
        if folder not in of_something:
            of_something[folder] = _is_of_something(folder)
            simulated[folder] = is_simulated(folder)
        if not of_something[folder]:
            continue
        try:
            changed = path.stat().st_mtime
        except OSError:  # just deleted
            continue
        name = workspace.name_of(folder) if folder != workspace.folder else "."
        found.append(ReportFile(workspace.name_of(path), kind, name, simulated[folder], changed))
    newest = {item.folder: 0.0 for item in found}
    for item in found:
        newest[item.folder] = max(newest[item.folder], item.changed)
    order = list(dict.fromkeys(KINDS.values()))
    found.sort(key=lambda item: (-newest[item.folder], item.folder, order.index(item.kind), item.path))
    return found[:MOST_LISTED]


def _is_of_something(folder: Path) -> bool:
    """Return whether a folder is a run's, a session's, an analysis', or holds a report: a picture alone is none."""
    marks = (RUN, SESSION, "report.html", *NUMBERS)
    return any((folder / name).is_file() for name in marks)


def is_simulated(folder: Path) -> bool:
    """Return whether the data of a run, or the numbers in a folder, say that they are simulated."""
    for name in ("data.json", *NUMBERS):
        try:
            values = json.loads((folder / name).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        if says_simulated(values):
            return True
    return False


def says_simulated(values: Any) -> bool:
    """Return whether a result says that its data, devices or participants are simulated."""
    if not isinstance(values, Mapping):
        return False
    if values.get("simulated") or "simulated" in str(values.get("name", "")):
        return True
    data = values.get("data")
    return says_simulated(data) if isinstance(data, Mapping) else "simulated" in str(data or "")


def readable_file(workspace: Workspace, name: str) -> tuple[Path, str]:
    """Return a file to be read and its media type.

    Raises
    ------
    DataError, ParameterError
        If it lies outside of the workspace, is not there, of another kind, or too large.
    """
    path = workspace.inside(name)
    own = workspace.own / "state"
    if path.suffix.lower() not in MEDIA or path.is_relative_to(own):
        raise ParameterError(f"{name[:200]}: only {', '.join(MEDIA)} are shown here")
    if not path.is_file():
        raise DataError(f"{name[:200]}: there is no such file in the workspace")
    if path.stat().st_size > MOST_BYTES:
        raise DataError(f"{name[:200]}: has more than {MOST_BYTES // 10**6} MB; open it yourself")
    return path, MEDIA[path.suffix.lower()]


def matching(words: str, texts: Iterable[str]) -> bool:
    """Return whether every word stands in one of the texts, in any case."""
    whole = " ".join(texts).lower()
    return all(word in whole for word in words.lower().split())


def published_html(rows: Sequence[Mapping[str, Any]], words: str = "") -> tuple[str, int]:
    """Return published figures beside ours as a table, and how many rows it has.

    Parameters
    ----------
    rows : sequence of mapping
        As `tactogram.workflows.table.table` gives them.
    words : str
        That a row must hold, all of them.
    """
    headings = (
        "Model",
        "What",
        "Published",
        "Ours",
        "Difference",
        "Seeds",
        "Data and split",
        "Why they differ",
    )
    found = [row for row in rows if matching(words, (str(value) for value in row.values()))]
    body = "".join(_published_row(row) for row in found)
    head = "".join(
        f'<th scope="col"{_text_class(i in (0, 1, 6, 7))}>{name}</th>' for i, name in enumerate(headings)
    )
    caption = '<caption class="sr-only">Published figures beside ours</caption>'
    return (
        f'<div class="scrolled" tabindex="0" role="region" aria-label="Published and ours, table">'
        f'<table class="numbers published">{caption}<thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    ), len(found)


def _published_row(row: Mapping[str, Any]) -> str:
    published, ours, sd = row["published"], row["ours"], row["sd"]
    difference = None if published is None or ours is None else ours - published
    where = f'<br><span class="quiet small">{html.escape(row["where"])}</span>' if row["where"] else ""
    mine = _number(ours) + (f" ± {sd:g}" if ours is not None and sd is not None else "")
    badge = ' <span class="simulated">simulated</span>' if "simulated" in str(row["data"]).lower() else ""
    data = html.escape(str(row["data"])) or "not measured"
    split = f'<br><span class="quiet small">{html.escape(str(row["split"]))}</span>' if row["split"] else ""
    note = f'<span class="small">{html.escape(str(row["note"]))}</span>' if row["note"] else ""
    cells = (
        ("text", html.escape(str(row["model"]))),
        ("text", html.escape(str(row["what"]))),
        ("", _number(published) + where),
        ("", mine),
        ("", "" if difference is None else f"{difference:+.3g}"),
        ("", str(row["seeds"]) if ours is not None else ""),
        ("text wide", f"{data}{badge}{split}"),
        ("text wide", note),
    )
    return "<tr>" + "".join(f'<td class="{kind}">{text}</td>' for kind, text in cells) + "</tr>"


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"


def _text_class(text: bool) -> str:
    return ' class="text"' if text else ""


def numbers_html(values: Any) -> str:
    """Return JSON values as nested tables of names and values, for people."""
    if isinstance(values, Mapping):
        rows = "".join(
            f'<tr><th scope="row" class="text">{html.escape(str(key)).replace("_", " ")}</th>'
            f'<td class="text">{numbers_html(value)}</td></tr>'
            for key, value in values.items()
        )
        return f'<table class="numbers">{rows}</table>'
    if isinstance(values, list):
        if len(values) > 30:
            shown = ", ".join(_plain(v) for v in values[:10])
            return html.escape(f"{shown} … ({len(values)} in all)")
        if all(not isinstance(v, Mapping | list) for v in values):
            return html.escape(", ".join(_plain(v) for v in values))
        return "".join(f"<div>{numbers_html(v)}</div>" for v in values)
    return html.escape(_plain(values))


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.5g}"
    if isinstance(value, Mapping | list):
        return json.dumps(value, ensure_ascii=False)[:200]
    return "none" if value is None else str(value)[:4000]


@dataclass(frozen=True)
class ExperimentEntry:
    """An experiment, and its results that lie at hand.

    Parameters
    ----------
    name, title, command : str
    results : tuple of Path
        ``NAME.json`` beside the source, ``runs/NAME/result.json`` of the workspace.
    """

    name: str
    title: str
    command: str
    results: tuple[Path, ...]


def experiments_with_results(workspace: Workspace) -> list[ExperimentEntry]:
    """Return the experiments behind published tables and, beside the source, our own, with the results at hand."""
    found = []
    for folder, command in COMMANDS.items():
        for name, title in experiments(folder).items():
            places = (
                BENCHMARKS / "reproduced" / f"{name}.json",
                workspace.folder / "runs" / name / "result.json",
            )
            results = tuple(path for path in places if path.is_file())
            found.append(ExperimentEntry(name, title, f"{command} {name}", results))
    return found


def result_of(path: Path) -> dict[str, Any]:
    """Return a result of an experiment.

    Raises
    ------
    DataError
        If it cannot be read.
    """
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DataError(f"{path.name}: not readable: {error}") from error
    if not isinstance(values, dict):
        raise DataError(f"{path.name}: expected a table of results")
    return values
