"""Saved effects of the workspace: each a folder with ``effect.json``, replaced after every change."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tactogram.errors import DataError
from tactogram.rendering import Effect, effect_from_json
from tactogram.signal.io import write_text
from tactogram.text_files import read_text
from tactogram_studio.workspace.dated_folders import DatedFolders

FILE = "effect.json"


@dataclass(frozen=True)
class SavedEffects:
    """The effects in ``folder``."""

    folder: Path

    @property
    def _folders(self) -> DatedFolders:
        return DatedFolders(self.folder)

    def add(self, effect: Effect) -> str:
        """Save a new effect and return its id."""
        return self._folders.add(lambda part: write_text(part / FILE, effect.to_json()))

    def save(self, identifier: str, effect: Effect) -> None:
        """Replace an effect; `DataError` if it was deleted."""
        write_text(self._folder(identifier) / FILE, effect.to_json())

    def get(self, identifier: str) -> Effect:
        """Return an effect; `DataError` if there is none, or its file is damaged."""
        path = self._folder(identifier) / FILE
        return effect_from_json(read_text(path), where=str(path))

    def titles(self) -> dict[str, str]:
        """Return the titles of the readable effects by id, newest first."""
        titles = {}
        for identifier in self._folders.names():
            with suppress(DataError):
                titles[identifier] = self.get(identifier).title
        return titles

    def remove(self, identifier: str) -> None:
        """Delete an effect."""
        self._folder(identifier)
        self._folders.remove(identifier)

    def _folder(self, identifier: str) -> Path:
        folder = self._folders.find(identifier)
        if folder is None:
            raise DataError(
                f"no effect {identifier[:40]!r}; it was deleted: choose another, or begin a new one"
            )
        return folder
