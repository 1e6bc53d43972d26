"""Folders that are named after when they were made, each written beside and renamed: none is there half."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

ID = re.compile(r"[0-9]{8}-[0-9]{6}-[0-9]{6}")
"""Date, time and microsecond, UTC, so that names are in order."""
LEFT_OVER = timedelta(days=1)
"""What was begun so long ago and is not whole is nobody's any more: writing one takes seconds."""
_FORMAT = "%Y%m%d-%H%M%S-%f"
_LEFT = re.compile(rf"\.(?P<id>{ID.pattern})\.(?P<state>part|gone)")


@dataclass(frozen=True)
class DatedFolders:
    """The folders in a folder, which need not be there yet."""

    folder: Path

    def add(self, write: Callable[[Path], object]) -> str:
        """Make a folder that ``write`` fills, and return its name; nothing is left where ``write`` fails."""
        self.folder.mkdir(parents=True, exist_ok=True)
        now = datetime.now(UTC)
        self._clear(now - LEFT_OVER)
        while (made := self._begun(f"{now:{_FORMAT}}")) is None:
            now += timedelta(microseconds=1)
        identifier, part = made
        try:
            write(part)
            part.rename(self.folder / identifier)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        return identifier

    def _begun(self, identifier: str) -> tuple[str, Path] | None:
        """Return a name and the folder to fill for it, None if another takes it."""
        part = self.folder / f".{identifier}.part"
        if (self.folder / identifier).exists():
            return None
        try:
            part.mkdir()
        except FileExistsError:
            return None
        return identifier, part

    def names(self) -> list[str]:
        """Return the names, newest first."""
        if not self.folder.is_dir():
            return []
        return sorted((path.name for path in self.folder.iterdir() if ID.fullmatch(path.name)), reverse=True)

    def find(self, identifier: str) -> Path | None:
        """Return a folder by its name; None where there is none, or the name is none."""
        folder = self.folder / identifier
        return folder if ID.fullmatch(identifier) and folder.is_dir() else None

    def remove(self, identifier: str) -> None:
        """Delete a folder, at once for whoever looks."""
        gone = self.folder / f".{identifier}.gone"
        (self.folder / identifier).rename(gone)
        shutil.rmtree(gone, ignore_errors=True)

    def _clear(self, before: datetime) -> None:
        """Remove what a server that was killed left: half deleted, or half made and begun ``before``."""
        for path in self.folder.iterdir():
            left = _LEFT.fullmatch(path.name)
            if left and (left["state"] == "gone" or left["id"] < f"{before:{_FORMAT}}"):
                shutil.rmtree(path, ignore_errors=True)
