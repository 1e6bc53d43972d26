"""Send service: renders signals of the workspace for a display or as haptic files, with reports.

The work is done by the functions behind the command line, in a folder under ``studio/sent`` that also holds the
request: a reload finds the result, and the same command makes the same file.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.recipe import parse_changes
from tactogram.rendering import file_name, haptic_formats, shipped
from tactogram.text_files import displayable, read_json
from tactogram.workflows import convert, render
from tactogram_studio.workspace.commands import arguments, command_line, stem_of
from tactogram_studio.workspace.folder import FACTS, DatedFolders, Workspace
from tactogram_studio.workspace.shelf import ResultArchive, SelectedSignal, SignalSources

MOST_RESULTS = 40
"""Older results are deleted."""
DRIVE_SUFFIXES = (".wav", ".csv", ".npz")
LEVELS = {
    "physical": "The output equals the signal, in its own unit. Recordings often feel weak this way.",
    "sensation": "As far above the detection threshold as the signal; frequencies that the display cannot "
    "render are compensated by others. A number sets the level above the threshold in dB.",
    "gain": "Output per unit of the signal.",
    "peak": "The largest drive is this share of the limit. The signal's own strength is lost.",
}
LEVEL_VALUES = {
    "gain": ("Factor", 1.0),
    "peak": ("Share of the limit, 0 to 1", 0.5),
    "sensation": ("dB above the threshold (empty: as the signal)", None),
}
"""Label and default of a level's number."""


@dataclass(frozen=True)
class DriveRequest:
    """Request to render the signal ``of`` for a display; see `tactogram.workflows.rendering.render.render`."""

    of: str
    display: str
    level: str
    how: str = ""
    speed_mm_s: float | None = None
    calibration: str = ""
    person: str = ""
    changes: tuple[str, ...] = ()


@dataclass(frozen=True)
class FileRequest:
    """Request to store the signal ``of`` as a haptic file; see `tactogram.workflows.data.convert.convert`.

    Without a format, all of them.
    """

    of: str
    format: str = ""
    axis: str = ""
    full_scale: float | None = None
    play_at: float | None = None


@dataclass(frozen=True)
class SendResult:
    """A drive or haptic files in a folder named ``id``.

    ``facts`` are JSON values of `render` or `convert`, and ``commands``, the equivalent command lines.
    """

    id: str
    folder: Path
    request: DriveRequest | FileRequest
    title: str
    facts: Mapping[str, Any]


class SendService:
    """Makes and finds results."""

    def __init__(self, workspace: Workspace, shelf: ResultArchive) -> None:
        self.workspace = workspace
        self.sources = SignalSources(workspace, shelf)
        self.folder = workspace.studio_folder / "sent"
        self._folders = DatedFolders(self.folder)

    def calibrations(self) -> dict[str, str]:
        """Return the files that `tactogram calibrate` wrote, by path relative to the workspace."""
        files = [path for path, values in self.workspace.toml_files() if "calibration" in values]
        return {(name := self.workspace.name_of(path)): name for path in files}

    def displays(self) -> dict[str, str]:
        """Return the titles of the workspace's own displays, by path relative to the workspace."""
        return {
            self.workspace.name_of(path): str(values.get("title", displayable(path.stem)))
            for path, values in self.workspace.toml_files()
            if "family" in values and "channels" in values
        }

    def display_file(self, name: str) -> str:
        """Return the argument of `open_display`: a shipped name, or the full path of a display in the workspace."""
        return name if name in shipped() else str(self.workspace.inside(name))

    def drive(self, request: DriveRequest) -> SendResult:
        """Render a signal for a display, with report and figure; errors as of `render`, and no result then."""
        selected = self.sources.select(request.of)

        def make(folder: Path) -> dict[str, Any]:
            rendered = render(
                selected.file,
                out=folder / "drive.npz",
                figure=True,
                display=self.display_file(request.display),
                level=request.level,
                how=request.how or None,
                speed_mm_s=request.speed_mm_s,
                changes=parse_changes(list(request.changes)),
                calibration=self.workspace.inside(request.calibration) if request.calibration else None,
                person=request.person or None,
            )
            return {"report": rendered["report"], "text": rendered["text"]}

        options = {**asdict(request), "out": "drive.wav", "figure": True}
        return self._made(request, selected, make, [self._command("render", options, selected)])

    def drive_file(self, result: SendResult, suffix: str) -> Path:
        """Return the drive in a format, converted on first use."""
        if suffix not in DRIVE_SUFFIXES or not isinstance(result.request, DriveRequest):
            raise ParameterError(
                f"the format of a drive must be one of {', '.join(DRIVE_SUFFIXES)}, got {suffix[:20]!r}"
            )
        path = result.folder / f"drive{suffix}"
        if not path.is_file():
            convert(result.folder / "drive.npz", path)
        return path

    def file(self, request: FileRequest) -> SendResult:
        """Write a signal as one haptic file, or all formats that can store it, checked and with their losses.

        Raises `TactogramError` if the requested format cannot store it; there is no result then.
        """
        selected = self.sources.select(request.of)
        formats = haptic_formats()
        if request.format and request.format not in formats:
            raise ParameterError.one_of("format", formats, request.format[:40])
        names = [request.format] if request.format else list(formats)
        title = Path(selected.title).stem if request.of.startswith("file:") else selected.title
        stem = stem_of(title)

        def make(folder: Path) -> dict[str, Any]:
            files: dict[str, Any] = {}
            for name in names:
                path = folder / file_name(stem, name)
                try:
                    facts = convert(
                        selected.file,
                        path,
                        format=name,
                        axis=request.axis or None,
                        full_scale=request.full_scale,
                        play_at=request.play_at,
                    )
                    problems = convert(path, check=True, format=name)["problems"]
                except TactogramError as error:
                    if request.format:
                        raise
                    files[name] = {"refused": str(error)}
                else:
                    files[name] = {"file": path.name, "written": facts["written"], "problems": problems}
            return {"files": files}

        commands = [
            self._command("convert", {**asdict(request), "format": name}, selected, file_name(stem, name))
            for name in names
        ]
        return self._made(request, selected, make, commands)

    def get(self, identifier: str) -> SendResult:
        """Return a result by its id; `DataError` if there is none, or its files are damaged."""
        folder = self._folders.get(identifier, "result", " to make room for newer ones; make it again")
        facts = read_json(folder / FACTS)
        try:
            values = facts.pop("request")
            title, kind = values.pop("title"), values.pop("kind")
            request: DriveRequest | FileRequest
            if kind == "drive":
                request = DriveRequest(**{**values, "changes": tuple(values["changes"])})
            else:
                request = FileRequest(**values)
        except (AttributeError, KeyError, TypeError):
            raise DataError(folder / FACTS, "damaged; make the result again") from None
        return SendResult(identifier, folder, request, title, facts)

    def latest(self, selected: SelectedSignal, kind: type) -> SendResult | None:
        """Return the newest result of a signal by a kind of request, as long as its file has not changed since."""
        for identifier in self._folders.names():
            with suppress(DataError):
                result = self.get(identifier)
                of = result.request.of, result.facts.get("version")
                if isinstance(result.request, kind) and of == (selected.id, selected.version):
                    return result
        return None

    def _made(
        self,
        request: DriveRequest | FileRequest,
        selected: SelectedSignal,
        make: Callable[[Path], dict[str, Any]],
        commands: list[str],
    ) -> SendResult:
        kind = "drive" if isinstance(request, DriveRequest) else "file"
        values = {"kind": kind, "title": selected.title, **asdict(request)}
        version = selected.version

        def write(part: Path) -> dict[str, Any]:
            facts = {"commands": commands, "simulated": selected.simulated, "version": version}
            return make(part) | facts | {"request": values}

        return self.get(self._folders.add(write, most=MOST_RESULTS))

    def _command(self, verb: str, options: Mapping[str, Any], selected: SelectedSignal, *target: str) -> str:
        rest = {name: value for name, value in options.items() if name != "of"}
        return command_line(arguments(verb, self.workspace.name_of(selected.file), *target, **rest))


def level_text(kind: str, value: float | None) -> str:
    """Return a level in the command line's form."""
    return kind if value is None or kind == "physical" else f"{kind}={value:g}"
