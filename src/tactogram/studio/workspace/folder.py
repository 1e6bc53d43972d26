"""The folder that the studio works in: what lies there, and that nothing outside of it is reached."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tactogram.errors import DataError, ParameterError, TactogramError

OWN = "studio"
"""Folder for what the studio itself makes: kept results, first voices, its state."""
DEPTH = 4
"""How many folders deep runs, stores and sessions are looked for."""
MOST_FOLDERS = 5000
"""After which the search ends: a home folder is no workspace."""
PASSED_OVER = {"node_modules", "__pycache__", "build", "dist", "site-packages"}
RUN, STORE, SESSION = "recipe.toml", "dataset.json", "answers.sqlite"


@dataclass(frozen=True)
class Workspace:
    """A folder with runs, stores, studies and sessions.

    Parameters
    ----------
    folder : Path
        Absolute, and made where it is not there.
    """

    folder: Path

    @classmethod
    def at(cls, folder: Path | str) -> Workspace:
        """Return the workspace in ``folder``, which is made.

        Raises
        ------
        DataError
            If it cannot be written to.
        """
        path = Path(folder).resolve()
        if path.exists() and not path.is_dir():
            raise DataError(f"{path}: expected a folder to work in, got a file")
        path.mkdir(parents=True, exist_ok=True)
        if not os.access(path, os.W_OK | os.X_OK):
            raise DataError(f"{path}: cannot be written to; give another --folder")
        return cls(path)

    @property
    def own(self) -> Path:
        """Where the studio keeps what it makes itself."""
        return self.folder / OWN

    @property
    def shown(self) -> str:
        """How the folder is shown: ``~/lab`` for one in the user's home."""
        home = Path.home()
        return f"~/{self.folder.relative_to(home)}" if self.folder.is_relative_to(home) else str(self.folder)

    def inside(self, path: Path | str) -> Path:
        """Return ``path``, relative to the workspace or absolute, if it lies inside; links are followed first.

        Raises
        ------
        ParameterError
            If it leads out.
        """
        text = os.fspath(path)
        if "\0" in text:
            raise ParameterError("a path has no NUL character")
        whole = (self.folder / text).resolve()
        if not whole.is_relative_to(self.folder):
            raise ParameterError(f"{text[:200]}: lies outside of the workspace {self.folder}")
        return whole

    def name_of(self, path: Path) -> str:
        """Return how a path inside is called: relative to the workspace, with slashes."""
        return path.resolve().relative_to(self.folder).as_posix()

    @contextmanager
    def readable_errors(self) -> Iterator[None]:
        """Say in errors how a path inside is called (`name_of`), not where on the machine it lies."""
        try:
            yield
        except TactogramError as error:
            raise DataError(str(error).replace(f"{self.folder}/", "")) from error

    def runs(self) -> list[Path]:
        """Return the folders of runs, finished or not, newest first."""
        return sorted(self._having(RUN), key=_changed, reverse=True)

    def finished_runs(self) -> list[Path]:
        """Return the folders of finished runs, newest first."""
        return [run for run in self.runs() if (run / "model.json").is_file()]

    def stores(self) -> list[Path]:
        """Return the folders of data sets, by name."""
        return sorted(self._having(STORE))

    def sessions(self) -> list[Path]:
        """Return the folders of studies that were begun, newest first."""
        return sorted(self._having(SESSION), key=_changed, reverse=True)

    def studies(self) -> list[Path]:
        """Return the files that are studies: TOML with a table ``design``, by name."""
        return sorted(path for path in self._files(".toml") if _is_study(path))

    def files(self, *suffixes: str) -> list[Path]:
        """Return the files whose names end so, by name; those of the studio's own state are left out."""
        hidden = self.own / "state"
        found = [
            folder / name
            for folder, files in self._walk()
            if folder != hidden
            for name in files
            if name.lower().endswith(suffixes) and not name.startswith(".")
        ]
        return sorted(found)

    def _having(self, name: str) -> list[Path]:
        return [folder for folder, files in self._walk() if name in files]

    def _files(self, suffix: str) -> list[Path]:
        return [folder / name for folder, files in self._walk() for name in files if name.endswith(suffix)]

    def _walk(self) -> Iterator[tuple[Path, list[str]]]:
        for count, (text, folders, files) in enumerate(os.walk(self.folder)):
            folder = Path(text)
            deep = len(folder.relative_to(self.folder).parts)
            folders[:] = sorted(
                name
                for name in folders
                if deep < DEPTH and not name.startswith(".") and name not in PASSED_OVER
            )
            if count >= MOST_FOLDERS:
                return
            yield folder, files


def _changed(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:  # just deleted
        return 0.0


def _is_study(path: Path) -> bool:
    try:
        if path.stat().st_size > 1_000_000:
            return False
        return "design" in tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError):
        return False
