"""Kept results, and the signals of a workspace that can be selected."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tactogram import datasets
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_metadata, read_signal, write_image, write_signal, write_text
from tactogram.text_files import read_json
from tactogram_studio.workspace.folder import FACTS, STORE, DatedFolders, Workspace

SIGNAL, IMAGE, PHOTOGRAPH = "signal.npz", "image.png", "photograph"
LONGEST_TITLE = 120
MOST_LISTED = 1000
TABLES = ("metrics.csv", "metrics.jsonl", "words.csv")
"""Tables of runs, which hold no signals."""


@dataclass(frozen=True)
class KeptResult:
    """A kept result in a folder named ``id``, which sorts by age; ``facts`` are JSON values: condition, run, seed."""

    id: str
    folder: Path
    title: str
    facts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def is_image(self) -> bool:
        """Whether it is an image rather than a signal."""
        return (self.folder / IMAGE).is_file()

    @property
    def file(self) -> Path:
        """File of the signal or image."""
        return self.folder / (IMAGE if self.is_image else SIGNAL)

    def photograph(self) -> Image | None:
        """Return the photograph that the signal was drawn from, which shows ``width_mm`` of the facts; or None."""
        path = self.folder / PHOTOGRAPH
        return read_image(path, width_mm=float(self.facts["width_mm"])) if path.is_file() else None

    def signal(self) -> Signal:
        """Return the signal; `DataError` if it is an image, or was deleted."""
        if self.is_image:
            raise DataError(self.title, "is an image; a signal is needed")
        return read_signal(self.folder / SIGNAL)

    def image(self) -> Image:
        """Return the image; `DataError` if it is a signal, or was deleted."""
        if not self.is_image:
            raise DataError(self.title, "is a signal; an image is needed")
        return read_image(self.folder / IMAGE)


@dataclass(frozen=True)
class ResultArchive:
    """Kept results in a folder."""

    folder: Path

    def keep(
        self, result: Signal | Image, *, title: str, facts: Mapping[str, Any], photograph: bytes = b""
    ) -> KeptResult:
        """Store a signal or an image with a title and JSON values as facts; its file has some of them.

        ``photograph`` is the file of a picture that a signal was drawn from (see `KeptResult.photograph`).
        """
        metadata = {name: facts[name] for name in ("simulated", "limited") if facts.get(name)} or None

        def write(part: Path) -> None:
            if isinstance(result, Image):
                write_image(part / IMAGE, result, metadata=metadata)
            else:
                write_signal(part / SIGNAL, result, metadata=metadata)
            if photograph:
                (part / PHOTOGRAPH).write_bytes(photograph)

        return self._add(write, title, facts)

    def keep_copy(self, result: KeptResult) -> KeptResult:
        """Copy a result of another archive unchanged; `DataError` if it was deleted."""
        facts = {key: value for key, value in result.facts.items() if key != "kept_at"}
        if not result.file.is_file():
            raise DataError(result.title, "was deleted; make it again")
        return self._add(lambda part: shutil.copy(result.file, part / result.file.name), result.title, facts)

    @property
    def _folders(self) -> DatedFolders:
        return DatedFolders(self.folder)

    def _add(self, write: Callable[[Path], object], title: str, facts: Mapping[str, Any]) -> KeptResult:
        kept_at = datetime.now(UTC).isoformat(timespec="seconds")
        values = {"title": _checked_title(title), "kept_at": kept_at, **facts}

        def write_all(part: Path) -> Mapping[str, Any]:
            write(part)
            return values

        return self.get(self._folders.add(write_all))

    def all(self) -> list[KeptResult]:
        """Return the readable results, newest first."""
        results = []
        for name in self._folders.names():
            with suppress(DataError):
                results.append(self.get(name))
        return results

    def get(self, identifier: str) -> KeptResult:
        """Return a result by its id; `DataError` if there is none, or its facts cannot be read."""
        folder = self._folders.find(identifier)
        if folder is None or not (folder / FACTS).is_file():
            raise DataError(f"no kept result {identifier[:40]!r}; it was deleted or never existed")
        facts = read_json(folder / FACTS)
        if not isinstance(facts, dict):
            raise DataError(folder / FACTS, f"expected an object, got {type(facts).__name__}")
        return KeptResult(identifier, folder, str(facts.pop("title", identifier)), facts)

    def rename(self, identifier: str, title: str) -> KeptResult:
        """Change a result's title."""
        result = self.get(identifier)
        values = {"title": _checked_title(title), **result.facts}
        write_text(result.folder / FACTS, json.dumps(values, ensure_ascii=False, indent=1))
        return self.get(identifier)

    def remove(self, identifier: str) -> None:
        """Delete a result."""
        self._folders.remove(self.get(identifier).id)


def _checked_title(title: str) -> str:
    title = " ".join(title.split())
    if not title:
        raise ParameterError("a kept result needs a title")
    return title[:LONGEST_TITLE]


@dataclass(frozen=True)
class SelectedSignal:
    """Signal selected for sending; ``id`` is ``kept:ID``, ``file:PATH`` or ``recording:STORE#ID``."""

    id: str
    title: str
    file: Path
    simulated: bool

    @property
    def version(self) -> int:
        """Number that changes when a file of the user does; kept results and recordings never change."""
        return self.file.stat().st_mtime_ns if self.id.startswith("file:") else 0

    def signal(self) -> Signal:
        """Return the signal."""
        return read_signal(self.file)


@dataclass(frozen=True)
class SignalSources:
    """Signals of a workspace and its kept results, listed as titles by id."""

    workspace: Workspace
    shelf: ResultArchive

    def kept(self) -> dict[str, str]:
        """Return the kept signals."""
        return {
            f"kept:{result.id}": f"{result.title}{' (simulated)' if result.facts.get('simulated') else ''}"
            for result in self.shelf.all()
            if not result.is_image
        }

    def files(self) -> dict[str, str]:
        """Return the files that may hold signals, those of runs included."""
        names = [
            self.workspace.name_of(path)
            for path in self.workspace.signal_files()
            if path.name not in TABLES and not (path.parent / STORE).is_file()
        ]
        return {f"file:{name}": name for name in names[:MOST_LISTED]}

    def stores(self) -> dict[str, str]:
        """Return the data sets, by folder relative to the workspace."""
        return {(name := self.workspace.name_of(path)): name for path in self.workspace.stores()}

    def recordings(self, store: str) -> dict[str, str]:
        """Return the recordings of a data set."""
        opened = datasets.open_store(self.workspace.inside(store))
        return {
            f"recording:{store}#{info.id}": " · ".join(
                str(part) for part in (info.material, info.contactor, info.id[:12]) if part
            )
            for info in list(opened.index)[:MOST_LISTED]
        }

    def select(self, identifier: str) -> SelectedSignal:
        """Return the signal with an id; a recording is exported to a file first.

        Raises `DataError` or `ParameterError` if there is none, or it lies outside of the workspace.
        """
        kind, _, name = identifier.partition(":")
        if kind == "kept":
            kept = self.shelf.get(name)
            kept.signal()  # refuses an image
            return SelectedSignal(identifier, kept.title, kept.file, bool(kept.facts.get("simulated")))
        if kind == "file":
            path = self.workspace.inside(name)
            if not path.is_file():
                raise DataError(f"{name[:200]}: no such file in the workspace")
            facts = read_metadata(path)
            title = str(facts.get("uploaded", name))
            return SelectedSignal(identifier, title, path, bool(facts.get("simulated")))
        if kind == "recording":
            store, _, recording = name.partition("#")
            return self._recording(identifier, store, recording)
        raise ParameterError(f"choose a kept result, a file or a recording; got {identifier[:60]!r}")

    def _recording(self, identifier: str, store_name: str, recording: str) -> SelectedSignal:
        store = datasets.open_store(self.workspace.inside(store_name))
        if recording not in store:
            raise DataError(f"{store_name} has no recording {recording[:60]!r}")
        info = store.info(recording)
        streams = [stream for stream in store.streams_of(recording) if stream != "received"]
        signal = store.signal(recording, streams[0])
        safe = re.sub(r"[^A-Za-z0-9_.-]+", "-", f"{store_name}-{recording}")[:80]
        path = self.workspace.studio_folder / "exported" / f"{safe}.npz"
        path.parent.mkdir(parents=True, exist_ok=True)
        facts = {"store": store_name, "recording": recording, "simulated": store.simulated}
        write_signal(path, signal, metadata=facts)
        title = f"{info.material or 'recording'} {recording[:12]}, {store_name}"
        return SelectedSignal(identifier, title, path, store.simulated)
