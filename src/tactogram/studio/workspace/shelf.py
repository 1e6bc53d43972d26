"""The shelf: results that were kept, each a folder with the signal or image and what is known of it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tactogram.errors import DataError, ParameterError
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_image, read_signal, write_image, write_signal
from tactogram.signal.io.atomic import write_text
from tactogram.studio.workspace.dated_folders import DatedFolders

SIGNAL, IMAGE, FACTS = "signal.npz", "image.png", "facts.json"
LONGEST_TITLE = 120


@dataclass(frozen=True)
class KeptResult:
    """A kept result.

    Parameters
    ----------
    id : str
        Its folder's name: when it was kept, to the microsecond, so that names are in order.
    folder : Path
    title : str
    facts : mapping
        JSON values: condition, run, seed, whether simulated.
    """

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
        """The signal's or the image's file."""
        return self.folder / (IMAGE if self.is_image else SIGNAL)

    def signal(self) -> Signal:
        """Return the signal.

        Raises
        ------
        DataError
            If it is an image, or gone.
        """
        if self.is_image:
            raise DataError(f"{self.title}: is an image; a signal is needed")
        return read_signal(self.folder / SIGNAL)

    def image(self) -> Image:
        """Return the image.

        Raises
        ------
        DataError
            If it is a signal, or gone.
        """
        if not self.is_image:
            raise DataError(f"{self.title}: is a signal; an image is needed")
        return read_image(self.folder / IMAGE)


@dataclass(frozen=True)
class ResultArchive:
    """Kept results in a folder. Each is written beside and renamed: there is none that is half there."""

    folder: Path

    def keep(self, made: Signal | Image, *, title: str, facts: Mapping[str, Any]) -> KeptResult:
        """Write a signal or an image with what is known of it.

        Parameters
        ----------
        made : Signal or Image
        title : str
            What people call it.
        facts : mapping
            JSON values.
        """

        def write(part: Path) -> None:
            if isinstance(made, Image):
                write_image(part / IMAGE, made)
            else:
                write_signal(part / SIGNAL, made)

        return self._put(write, title, facts)

    def keep_copy(self, made: KeptResult) -> KeptResult:
        """Put a result of another shelf on this one; its samples or pixels stay as they are.

        Raises
        ------
        DataError
            If it is gone.
        """
        facts = {key: value for key, value in made.facts.items() if key != "kept_at"}
        if not made.file.is_file():
            raise DataError(f"{made.title}: is gone; make it again")
        return self._put(lambda part: shutil.copy(made.file, part / made.file.name), made.title, facts)

    @property
    def _folders(self) -> DatedFolders:
        return DatedFolders(self.folder)

    def _put(self, write: Callable[[Path], object], title: str, facts: Mapping[str, Any]) -> KeptResult:
        """Make a folder that ``write`` fills."""
        kept_at = datetime.now(UTC).isoformat(timespec="seconds")
        values = {"title": _titled(title), "kept_at": kept_at, **facts}

        def write_all(part: Path) -> None:
            write(part)
            (part / FACTS).write_text(json.dumps(values, ensure_ascii=False, indent=1), encoding="utf-8")

        return self.get(self._folders.add(write_all))

    def all(self) -> list[KeptResult]:
        """Return what is kept, newest first; what cannot be read is left out."""
        found = []
        for name in self._folders.names():
            with suppress(DataError):
                found.append(self.get(name))
        return found

    def get(self, identifier: str) -> KeptResult:
        """Return one by its id.

        Raises
        ------
        DataError
            If there is none.
        """
        folder = self._folders.find(identifier)
        if folder is None or not (folder / FACTS).is_file():
            raise DataError(f"no kept result {identifier[:40]!r}; it was removed, or never there")
        try:
            facts = json.loads((folder / FACTS).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise DataError(f"{folder / FACTS}: not readable: {error}") from error
        return KeptResult(identifier, folder, str(facts.pop("title", identifier)), facts)

    def rename(self, identifier: str, title: str) -> KeptResult:
        """Give one another title."""
        made = self.get(identifier)
        values = {"title": _titled(title), **made.facts}
        write_text(made.folder / FACTS, json.dumps(values, ensure_ascii=False, indent=1))
        return self.get(identifier)

    def remove(self, identifier: str) -> None:
        """Delete one."""
        self._folders.remove(self.get(identifier).id)


def _titled(title: str) -> str:
    title = " ".join(title.split())
    if not title:
        raise ParameterError("a kept result needs a title")
    return title[:LONGEST_TITLE]
