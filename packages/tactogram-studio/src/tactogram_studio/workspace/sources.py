"""Signals that can be sent: kept results, files and recordings of the workspace."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from tactogram.datasets import open_store
from tactogram.errors import DataError, ParameterError
from tactogram.signal import Signal
from tactogram.signal.io import read_metadata, read_signal, write_signal
from tactogram_studio.workspace.folder import STORE, Workspace
from tactogram_studio.workspace.shelf import ResultArchive

MOST_LISTED = 1000
TABLES = ("metrics.csv", "words.csv")
"""Tables of runs, which hold no signals."""


@dataclass(frozen=True)
class SelectedSignal:
    """Signal selected for sending; ``id`` is ``kept:ID``, ``file:PATH`` or ``recording:STORE#ID``."""

    id: str
    title: str
    file: Path
    simulated: bool

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
        hidden = [self.workspace.studio_folder / name for name in ("kept", "sent", "state", "first")]
        names = [
            self.workspace.name_of(path)
            for path in self.workspace.signal_files()
            if not any(path.is_relative_to(folder) for folder in hidden)
            and path.name not in TABLES
            and not (path.parent / STORE).is_file()
        ]
        return {f"file:{name}": name for name in names[:MOST_LISTED]}

    def stores(self) -> dict[str, str]:
        """Return the data sets, by folder relative to the workspace."""
        return {(name := self.workspace.name_of(path)): name for path in self.workspace.stores()}

    def recordings(self, store: str) -> dict[str, str]:
        """Return the recordings of a data set."""
        opened = open_store(self.workspace.inside(store))
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
            return SelectedSignal(identifier, name, path, bool(read_metadata(path).get("simulated")))
        if kind == "recording":
            store, _, recording = name.partition("#")
            return self._recording(identifier, store, recording)
        raise ParameterError(f"choose a kept result, a file or a recording; got {identifier[:60]!r}")

    def _recording(self, identifier: str, store_name: str, recording: str) -> SelectedSignal:
        store = open_store(self.workspace.inside(store_name))
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
