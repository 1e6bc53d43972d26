"""The studio's workspace folder, with its runs, stores and studies, and folders named after their creation time."""

from __future__ import annotations

import json
import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError, TactogramError
from tactogram.signal.io import READABLE
from tactogram.text_files import REPLACEMENT, displayable, read_toml

STUDIO = "studio"
"""Folder for the studio's own files: kept results, example surfaces, state."""
UPLOADS = ("uploads", "dropped", "photos", "vibrations", "motions")
"""Folders in it with files of the user."""
STROKES = "-strokes"
"""End of the name of a store beside the run of the same name: the strokes of a clone."""
FACTS = "facts.json"
"""File of a folder named after its creation time, with what is known of its content."""
DEPTH = 4
"""Levels of folders that are searched for runs, stores and sessions."""
MOST_FOLDERS = 5000
"""The search stops after this many: a home folder is not a workspace."""
SKIPPED = {"node_modules", "__pycache__", "build", "dist", "site-packages"}
RUN, STORE, SESSION = "recipe.toml", "dataset.json", "answers.sqlite"
ID = re.compile(r"[0-9]{8}-[0-9]{6}-[0-9]{6}")
"""Date, time and microsecond, UTC, so that names sort by age."""
ABANDONED_AFTER = timedelta(days=1)
"""Age from which an incomplete folder is deleted; writing one takes seconds."""
_FORMAT = "%Y%m%d-%H%M%S-%f"
_TEMPORARY = re.compile(rf"\.(?P<id>{ID.pattern})\.(?P<state>part|gone)")


@dataclass(frozen=True)
class Workspace:
    """A folder (an absolute path) with runs, stores, studies and sessions."""

    folder: Path

    @classmethod
    def at(cls, folder: Path | str) -> Workspace:
        """Return the workspace in ``folder``, creating it; `DataError` if it is a file or not writable."""
        path = Path(folder).resolve()
        if path.exists() and not path.is_dir():
            raise DataError(path, "the workspace must be a folder, got a file")
        path.mkdir(parents=True, exist_ok=True)
        if not os.access(path, os.W_OK | os.X_OK):
            raise DataError(path, "the workspace is not writable; use another folder")
        return cls(path)

    @property
    def studio_folder(self) -> Path:
        """Folder for the studio's own files."""
        return self.folder / STUDIO

    @property
    def display_path(self) -> str:
        """Path for pages: ``~/lab`` for a folder in the user's home."""
        home = Path.home()
        path = f"~/{self.folder.relative_to(home)}" if self.folder.is_relative_to(home) else str(self.folder)
        return displayable(path)

    def inside(self, path: Path | str) -> Path:
        """Return ``path``, relative to the workspace or absolute, with symbolic links followed.

        Raises `ParameterError` if it lies outside of the workspace, or replaces a name that is not UTF-8 (see
        `name_of`).
        """
        text = os.fspath(path)
        if "\0" in text or any(len(os.fsencode(part)) > 255 for part in text.split("/")):
            raise ParameterError("a path must not hold a NUL character, or a name of more than 255 bytes")
        whole = (self.folder / text).resolve()
        if not whole.is_relative_to(self.folder):
            raise ParameterError(f"{text[:200]}: lies outside of the workspace")
        if REPLACEMENT in text and not whole.exists():
            raise ParameterError(
                f"{text[:200]}: this name is not UTF-8 on the disk; rename the file or folder"
            )
        return whole

    def name_of(self, path: Path) -> str:
        """Return a path for pages: relative to the workspace, with slashes, and `displayable`."""
        return displayable(path.resolve().relative_to(self.folder).as_posix())

    @contextmanager
    def readable_errors(self) -> Iterator[None]:
        """Shorten paths in errors to those of `name_of`."""
        try:
            yield
        except TactogramError as error:
            raise DataError(error.message.replace(f"{self.folder}/", "")) from error

    def runs(self) -> list[Path]:
        """Return the folders of runs, finished or not, newest first."""
        return sorted(self._folders_with(RUN), key=_changed, reverse=True)

    def finished_runs(self) -> list[Path]:
        """Return the folders of finished runs, newest first."""
        return [run for run in self.runs() if (run / "model.json").is_file()]

    def stores(self) -> list[Path]:
        """Return the folders of data sets, by name, except the strokes that clones are made of."""
        return sorted(folder for folder in self._folders_with(STORE) if not _is_of_clone(folder))

    def sessions(self) -> list[Path]:
        """Return the folders of study sessions, newest first."""
        return sorted(self._folders_with(SESSION), key=_changed, reverse=True)

    def studies(self) -> list[Path]:
        """Return the study files, by name: TOML with a table ``design``."""
        return [path for path, values in self.toml_files() if "design" in values]

    def toml_files(self) -> Iterator[tuple[Path, dict[str, Any]]]:
        """Yield the readable TOML files and their values, by name."""
        for path in self.files(".toml"):
            try:
                yield path, read_toml(path)
            except DataError:
                continue

    def files(self, *suffixes: str) -> list[Path]:
        """Return the files with one of the suffixes, by name, except the studio's state."""
        hidden = self.studio_folder / "state"
        return sorted(
            folder / name
            for folder, files in self._walk()
            if folder != hidden
            for name in files
            if name.lower().endswith(suffixes) and not name.startswith(".")
        )

    def user_files(self, *suffixes: str) -> list[Path]:
        """Return the files with one of the suffixes, by name, except those that the studio made for itself."""
        shown = [self.studio_folder / name for name in UPLOADS]
        return [
            path
            for path in self.files(*suffixes)
            if not path.is_relative_to(self.studio_folder) or any(map(path.is_relative_to, shown))
        ]

    def signal_files(self) -> list[Path]:
        """Return the user's files that may hold signals, by name; notes and logs rarely do."""
        return self.user_files(*(suffix for suffix in READABLE if suffix not in (".txt", ".log")))

    def recording_folders(self) -> list[Path]:
        """Return the folders with signal files in or below them, by name, except runs, stores and the studio's own."""
        others = {self.studio_folder}
        folders: set[Path] = set()
        for folder, files in self._walk():
            if {RUN, STORE, SESSION} & {*files}:
                others.add(folder)
            above = [folder, *folder.parents]
            above = above[: above.index(self.folder)]
            if not others.intersection(above) and any(name.lower().endswith(READABLE) for name in files):
                folders.update(above)
        return sorted(folders)

    def _folders_with(self, name: str) -> list[Path]:
        return [folder for folder, files in self._walk() if name in files]

    def _walk(self) -> Iterator[tuple[Path, list[str]]]:
        for count, (text, folders, files) in enumerate(os.walk(self.folder)):
            folder = Path(text)
            depth = len(folder.relative_to(self.folder).parts)
            folders[:] = sorted(
                name
                for name in folders
                if depth < DEPTH
                and not name.startswith(".")
                and ".part-" not in name  # an unfinished store
                and name not in SKIPPED
            )
            if count >= MOST_FOLDERS:
                return
            yield folder, files


def _is_of_clone(store: Path) -> bool:
    return store.name.endswith(STROKES) and (store.with_name(store.name[: -len(STROKES)]) / RUN).is_file()


def _changed(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:  # just deleted
        return 0.0


@dataclass(frozen=True)
class DatedFolders:
    """The folders in ``folder``, which is created on first use."""

    folder: Path

    def add(self, write: Callable[[Path], Mapping[str, Any] | None], *, most: int | None = None) -> str:
        """Create a folder, fill it by ``write`` and return its name; if ``write`` fails, nothing is left.

        What ``write`` returns is stored as `FACTS`. The oldest are deleted if there are more than ``most`` then.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        now = datetime.now(UTC)
        self._clear(now - ABANDONED_AFTER)
        while (started := self._start(f"{now:{_FORMAT}}")) is None:
            now += timedelta(microseconds=1)
        identifier, part = started
        try:
            if (facts := write(part)) is not None:
                (part / FACTS).write_text(json.dumps(facts, ensure_ascii=False, indent=1), encoding="utf-8")
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
