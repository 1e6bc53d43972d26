"""Send service: a signal of the workspace to the drive of a display or to haptic files, with reports.

Everything is made by the jobs that the command line calls, in a folder of its own under ``studio/sent``, beside what
was asked for; so a reload finds it again, and the same command makes the same file.
"""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tactogram.datasets import open_store
from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.recipe import parse_changes
from tactogram.rendering.displays.catalogue import shipped
from tactogram.rendering.files.catalogue import haptic_formats
from tactogram.signal import Signal
from tactogram.signal.io import READABLE, read_metadata, read_signal, write_signal
from tactogram.studio.pages.send.losses import file_name, zip_files
from tactogram.studio.workspace.dated_folders import DatedFolders
from tactogram.studio.workspace.folder import Workspace
from tactogram.studio.workspace.shelf import ResultArchive
from tactogram.workflows.data.convert import check, convert
from tactogram.workflows.rendering.render import render

KEPT = 40
"""How many results are kept; the oldest go."""
MOST_LISTED = 1000
DRIVES = (".wav", ".csv", ".npz")
ORDER, FOUND, ZIP = "order.json", "found.json", "all-formats.zip"


@dataclass(frozen=True)
class SelectedSignal:
    """Signal selected for sending, as a file.

    Parameters
    ----------
    of : str
        ``kept:ID``, ``file:PATH`` or ``recording:STORE#ID``.
    title : str
    file : Path
    simulated : bool
    """

    of: str
    title: str
    file: Path
    simulated: bool

    def signal(self) -> Signal:
        """Return the signal.

        Raises
        ------
        TactogramError
            If the file is none.
        """
        return read_signal(self.file)


@dataclass(frozen=True)
class DriveRequest:
    """A signal for a display; see `tactogram.workflows.rendering.render.render`."""

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
    """A signal for a haptic file; see `tactogram.workflows.data.convert.convert`. No format means all of them."""

    of: str
    format: str = ""
    axis: str = ""
    full_scale: float | None = None
    play_at: float | None = None


@dataclass(frozen=True)
class SendResult:
    """A result.

    Parameters
    ----------
    id : str
        Its folder's name.
    folder : Path
    order : DriveOrder or FileOrder
    title : str
        Of what was sent.
    found : mapping
        What the jobs said, and ``commands``: how the command line does the same.
    """

    id: str
    folder: Path
    order: DriveRequest | FileRequest
    title: str
    found: Mapping[str, Any]


class SendService:
    """The results in a folder.

    Parameters
    ----------
    workspace : Workspace
    shelf : Shelf
    """

    def __init__(self, workspace: Workspace, shelf: ResultArchive) -> None:
        self.workspace, self.shelf = workspace, shelf
        self.folder = workspace.studio_folder / "sent"
        self._folders = DatedFolders(self.folder)

    # -- what can be sent --------------------------------------------------------------------------------

    def kept(self) -> dict[str, str]:
        """Return kept signals: titles by ``of``."""
        return {
            f"kept:{made.id}": f"{made.title}{' (simulated)' if made.facts.get('simulated') else ''}"
            for made in self.shelf.all()
            if not made.is_image
        }

    def files(self) -> dict[str, str]:
        """Return files of the workspace that may be signals, those of runs among them: names by ``of``."""
        own = [self.workspace.studio_folder / name for name in ("kept", "sent", "state", "first")]
        found = {}
        for path in self.workspace.files(*READABLE):
            if any(path.is_relative_to(folder) for folder in own) or path.suffix == ".txt":
                continue
            if path.name in ("metrics.csv", "words.csv") or (path.parent / "dataset.json").is_file():
                continue
            found[f"file:{self.workspace.name_of(path)}"] = self.workspace.name_of(path)
        return dict(list(found.items())[:MOST_LISTED])

    def stores(self) -> dict[str, str]:
        """Return data sets: names by folder relative to the workspace."""
        return {(name := self.workspace.name_of(path)): name for path in self.workspace.stores()}

    def recordings(self, store: str) -> dict[str, str]:
        """Return the recordings of a data set: what they are by ``of``."""
        opened = open_store(self.workspace.inside(store))
        return {
            f"recording:{store}#{info.id}": " · ".join(
                str(part) for part in (info.material, info.contactor, info.id[:12]) if part
            )
            for info in list(opened.index)[:MOST_LISTED]
        }

    def chosen(self, of: str) -> SelectedSignal:
        """Return what ``of`` names; a recording is written as a file first.

        Raises
        ------
        DataError, ParameterError
            If there is none, or it lies outside of the workspace.
        """
        kind, _, name = of.partition(":")
        if kind == "kept":
            made = self.shelf.get(name)
            made_file = made.file
            made.signal()
            return SelectedSignal(of, made.title, made_file, bool(made.facts.get("simulated")))
        if kind == "file":
            path = self.workspace.inside(name)
            if not path.is_file():
                raise DataError(f"{name[:200]}: there is no such file in the workspace")
            return SelectedSignal(of, name, path, bool(read_metadata(path).get("simulated")))
        if kind == "recording":
            store_name, _, identifier = name.partition("#")
            return self._recording(of, store_name, identifier)
        raise ParameterError(f"choose what to send: a kept result, a file or a recording; got {of[:60]!r}")

    def _recording(self, of: str, store_name: str, identifier: str) -> SelectedSignal:
        store = open_store(self.workspace.inside(store_name))
        if identifier not in store:
            raise DataError(f"{store_name} holds no recording {identifier[:60]!r}")
        info = store.info(identifier)
        streams = [stream for stream in store.streams_of(identifier) if stream != "received"]
        signal = store.signal(identifier, streams[0])
        safe = re.sub(r"[^A-Za-z0-9_.-]+", "-", f"{store_name}-{identifier}")[:80]
        path = self.workspace.studio_folder / "exported" / f"{safe}.npz"
        path.parent.mkdir(parents=True, exist_ok=True)
        facts = {"store": store_name, "recording": identifier, "simulated": store.simulated}
        write_signal(path, signal, metadata=facts)
        title = f"{info.material or 'recording'} {identifier[:12]}, {store_name}"
        return SelectedSignal(of, title, path, store.simulated)

    def calibrations(self) -> dict[str, str]:
        """Return files that `tactogram calibrate` wrote: names by path relative to the workspace."""
        found = {}
        for path in self.workspace.files(".toml"):
            try:
                if path.stat().st_size < 1e6 and "calibration" in tomllib.loads(
                    path.read_text(encoding="utf-8")
                ):
                    found[self.workspace.name_of(path)] = self.workspace.name_of(path)
            except (OSError, ValueError):
                continue
        return found

    def displays(self) -> dict[str, str]:
        """Return displays of the workspace's own, TOML with a ``family``: names by path relative to the workspace."""
        found = {}
        for path in self.workspace.files(".toml"):
            try:
                values = tomllib.loads(path.read_text(encoding="utf-8")) if path.stat().st_size < 1e6 else {}
            except (OSError, ValueError):
                continue
            if "family" in values and "channels" in values:
                found[self.workspace.name_of(path)] = str(values.get("title", path.stem))
        return found

    def formats(self) -> dict[str, str]:
        """Return the haptic formats: titles by name."""
        return {name: f"{kind.title} ({kind.suffix})" for name, kind in haptic_formats().items()}

    def display_file(self, name: str) -> str:
        """Return how a display is opened: a shipped one by its name, another by its whole path inside."""
        return name if name in shipped() else str(self.workspace.inside(name))

    # -- what is made of it ------------------------------------------------------------------------------

    def drive(self, order: DriveRequest) -> SendResult:
        """Render a signal for a display; drive, report and its picture lie in the result's folder.

        Raises
        ------
        TactogramError
            As `tactogram.workflows.rendering.render.render`; nothing is kept then.
        """
        chosen = self.chosen(order.of)

        def make(folder: Path) -> dict[str, Any]:
            result = render(
                chosen.file, out=folder / "drive.npz", report_figure=True, **self._rendering(order)
            )
            return {"report": result["report"], "text": result["text"]}

        return self._made(order, chosen, make, [self._render_command(order, chosen)])

    def _rendering(self, order: DriveRequest) -> dict[str, Any]:
        return {
            "display": self.display_file(order.display),
            "level": order.level,
            "how": order.how or None,
            "speed_mm_s": order.speed_mm_s,
            "changes": parse_changes(list(order.changes)),
            "calibration": self.workspace.inside(order.calibration) if order.calibration else None,
            "person": order.person or None,
        }

    def drive_file(self, sent: SendResult, suffix: str) -> Path:
        """Return the drive in another format, made by the same job on first asking."""
        if suffix not in DRIVES or not isinstance(sent.order, DriveRequest):
            raise ParameterError(f"a drive is given as {', '.join(DRIVES)}, got {suffix[:20]!r}")
        path = sent.folder / f"drive{suffix}"
        if not path.is_file():
            render(self.chosen(sent.order.of).file, out=path, **self._rendering(sent.order))
        return path

    def file(self, order: FileRequest) -> SendResult:
        """Write a signal as one haptic file, or as all that can hold it, checked, with what each loses.

        Raises
        ------
        TactogramError
            If the one that is asked for cannot hold it; nothing is kept then.
        """
        chosen = self.chosen(order.of)
        formats = haptic_formats()
        if order.format and order.format not in formats:
            raise ParameterError(f"format must be one of {', '.join(formats)}, got {order.format[:40]!r}")
        names = [order.format] if order.format else list(formats)
        named = Path(chosen.title).stem if order.of.startswith("file:") else chosen.title
        stem = re.sub(r"[^A-Za-z0-9_-]+", "-", named)[:40].strip("-") or "touch"

        def make(folder: Path) -> dict[str, Any]:
            files: dict[str, Any] = {}
            for name in names:
                path = folder / file_name(stem, name)
                try:
                    files[name] = self._converted(order, chosen, name, path)
                except TactogramError as error:
                    if order.format:
                        raise
                    files[name] = {"refused": str(error)}
            if not order.format:
                zip_files(folder, ZIP, files, simulated=chosen.simulated)
            return {"files": files, "zip": ZIP if not order.format else None}

        commands = [self._convert_command(order, chosen, name, file_name(stem, name)) for name in names]
        return self._made(order, chosen, make, commands)

    def _converted(self, order: FileRequest, chosen: SelectedSignal, name: str, path: Path) -> dict[str, Any]:
        options: dict[str, Any] = {
            "format": name,
            "axis": order.axis or None,
            "full_scale": order.full_scale,
            "play_at": order.play_at,
        }
        facts = convert(chosen.file, path, **options)
        checked = check(path, format=name)
        return {"file": path.name, "written": facts["written"], "problems": checked["problems"]}

    def get(self, identifier: str) -> SendResult:
        """Return a result by its id.

        Raises
        ------
        DataError
            If there is none.
        """
        folder = self._folders.find(identifier)
        gone = DataError(f"no result {identifier[:40]!r}: it was replaced by newer ones; make it again")
        if folder is None:
            raise gone
        try:
            values = json.loads((folder / ORDER).read_text(encoding="utf-8"))
            found = json.loads((folder / FOUND).read_text(encoding="utf-8"))
        except (OSError, ValueError):
            raise gone from None
        title, kind = values.pop("title"), values.pop("kind")
        order: DriveRequest | FileRequest
        if kind == "drive":
            order = DriveRequest(**{**values, "changes": tuple(values["changes"])})
        else:
            order = FileRequest(**values)
        return SendResult(identifier, folder, order, title, found)

    def _made(
        self,
        order: DriveRequest | FileRequest,
        chosen: SelectedSignal,
        make: Callable[[Path], dict[str, Any]],
        commands: list[str],
    ) -> SendResult:
        kind = "drive" if isinstance(order, DriveRequest) else "file"
        values = {"kind": kind, "title": chosen.title, **asdict(order)}

        def write(part: Path) -> None:
            found = make(part) | {"commands": commands, "simulated": chosen.simulated}
            (part / ORDER).write_text(json.dumps(values, ensure_ascii=False), encoding="utf-8")
            (part / FOUND).write_text(json.dumps(found, ensure_ascii=False), encoding="utf-8")

        made = self._folders.add(write)
        for old in self._folders.names()[KEPT:]:
            self._folders.remove(old)
        return self.get(made)

    # -- the same on the command line --------------------------------------------------------------------

    def _render_command(self, order: DriveRequest, chosen: SelectedSignal) -> str:
        words = ["tactogram", "render", self._named(chosen.file), "--display", order.display]
        words += ["--level", order.level]
        words += ["--as", order.how] if order.how else []
        words += ["--speed", f"{order.speed_mm_s:g}"] if order.speed_mm_s is not None else []
        words += ["--calibration", order.calibration] if order.calibration else []
        words += ["--person", order.person] if order.person else []
        for change in order.changes:
            words += ["--set", change]
        return shlex.join([*words, "--out", "drive.wav", "--figure"])

    def _convert_command(self, order: FileRequest, chosen: SelectedSignal, name: str, target: str) -> str:
        words = ["tactogram", "convert", self._named(chosen.file), target, "--format", name]
        words += ["--axis", order.axis] if order.axis else []
        words += ["--full-scale", f"{order.full_scale:g}"] if order.full_scale is not None else []
        words += ["--play-at", f"{order.play_at:g}"] if order.play_at is not None else []
        return shlex.join(words)

    def _named(self, path: Path) -> str:
        return self.workspace.name_of(path) if path.is_relative_to(self.workspace.folder) else str(path)
