"""Folders named after their creation time, written under a temporary name and renamed: none is ever incomplete."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from tactogram.errors import DataError

ID = re.compile(r"[0-9]{8}-[0-9]{6}-[0-9]{6}")
"""Date, time and microsecond, UTC, so that names sort by age."""
ABANDONED_AFTER = timedelta(days=1)
"""Age from which an incomplete folder is deleted; writing one takes seconds."""
_FORMAT = "%Y%m%d-%H%M%S-%f"
_TEMPORARY = re.compile(rf"\.(?P<id>{ID.pattern})\.(?P<state>part|gone)")


@dataclass(frozen=True)
class DatedFolders:
    """The folders in ``folder``, which is created on first use."""

    folder: Path

    def add(self, write: Callable[[Path], object], *, most: int | None = None) -> str:
        """Create a folder, fill it by ``write`` and return its name; if ``write`` fails, nothing is left.

        The oldest are deleted if there are more than ``most`` then.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        now = datetime.now(UTC)
        self._clear(now - ABANDONED_AFTER)
        while (started := self._start(f"{now:{_FORMAT}}")) is None:
            now += timedelta(microseconds=1)
        identifier, part = started
        try:
            write(part)
            part.rename(self.folder / identifier)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
        for old in self.names()[most:] if most else ():
            self.remove(old)
        return identifier

    def _start(self, identifier: str) -> tuple[str, Path] | None:
        """Return a name and its temporary folder; None if the name is taken."""
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
        """Return a folder by its name, or None."""
        folder = self.folder / identifier
        return folder if ID.fullmatch(identifier) and folder.is_dir() else None

    def get(self, identifier: str, what: str, reason: str) -> Path:
        """Return a folder by its name; raise `DataError` with a reason and a remedy if there is none."""
        folder = self.find(identifier)
        if folder is None:
            raise DataError(f"no {what} {identifier[:40]!r}: it was deleted{reason}")
        return folder

    def remove(self, identifier: str) -> None:
        """Delete a folder; it disappears at once, however long its deletion takes."""
        gone = self.folder / f".{identifier}.gone"
        (self.folder / identifier).rename(gone)
        shutil.rmtree(gone, ignore_errors=True)

    def _clear(self, before: datetime) -> None:
        """Delete what a killed server left: deletions, and folders started ``before``."""
        for path in self.folder.iterdir():
            match = _TEMPORARY.fullmatch(path.name)
            if match and (match["state"] == "gone" or match["id"] < f"{before:{_FORMAT}}"):
                shutil.rmtree(path, ignore_errors=True)
