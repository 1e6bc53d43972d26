"""Importers: modules that read the files of one data set as recordings.

An importer is a module in `tactogram.datasets.importers`, or one that `IMPORTERS` finds elsewhere; the file's name is
the word after ``data import``. It defines

- ``TITLE``, ``LICENCE`` (what the source states, else ``"not stated"``) and ``DESCRIPTION`` (what is read, in which
  units, and which parts were checked on real files), all ``str``;
- ``find(folder: Path) -> list[ImportItem]``: a quick look at names and tables, in a stable order, that opens no signal.
  Its keyword-only parameters, each with a default, are the options of the import;
- ``read(item: ImportItem) -> list[Recording | LeftOut]``: the recordings of one item, and its parts that are none. It
  runs in another process, so that every core reads; the message of a `TactogramError` gets the item's name;
- optionally ``photographs(folder: Path) -> list[ImportedPhotograph]``: photographs of materials rather than of single
  recordings. It receives those options of ``find`` that it also declares; the import opens the files;
- optionally ``UNVERIFIED: str``: what was assumed of a set whose files were not at hand, repeated in the result of an
  import;
- optionally ``left_out(folder: Path) -> list[tuple[str, str]]``: files that may be recordings and are not read, each
  with the reason. An import reports them; without ``skip_bad`` a third of all files or more stop it;
- optionally ``paths(folder: Path) -> PathReading``: what the paths suggest, and a question that stops an import until
  an option answers it. It receives options as ``photographs`` does;
- optionally ``ratings(folder: Path) -> Ratings | None``; ratings of items that are not imported are left out.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, cast

from tactogram.datasets.recording import Recording, natural_key
from tactogram.errors import ParameterError
from tactogram.plugins import PluginGroup

IMPORTERS = PluginGroup(
    "importer",
    "tactogram.datasets.importers",
    "tactogram.importers",
    "TACTOGRAM_IMPORTERS",
    extra="benchmark",
)


@dataclass(frozen=True)
class ImportItem:
    """Unit of reading: one recording, or one file that holds several.

    ``name`` is its path relative to the imported folder, with ``/``; `Recording.source` starts with it, and errors name
    it. A missing or empty file of ``paths`` is an error before `read` is called. Items may share an ``image``, the
    photograph of every recording, of the material in ``info`` if that states one: the import opens and stores it once.
    """

    name: str
    paths: tuple[Path, ...]
    info: Mapping[str, Any] = field(default_factory=dict)  # for `read`: anything that can be pickled
    image: Path | None = None
    image_width_mm: float | None = None  # width of surface that the photograph shows


@dataclass(frozen=True)
class LeftOut:
    """Part of an item that is no recording; an import reports it, and stops without ``skip_bad`` if it is broken."""

    part: str  # its number or name within the item
    reason: str  # one line, which names the item
    broken: bool = False


@dataclass(frozen=True)
class ImportedPhotograph:
    """Photograph of a material, of which there need be no recording; ``name`` is its path relative to the folder."""

    name: str
    path: Path
    material: str
    width_mm: float | None = None


class Importer(Protocol):
    """Members that every importer module defines."""

    TITLE: str
    LICENCE: str
    DESCRIPTION: str

    def find(self, folder: Path) -> list[ImportItem]:
        """Return the items in ``folder`` in a stable order; `DataError` if it does not hold this data set."""
        ...

    def read(self, item: ImportItem) -> Sequence[Recording | LeftOut]:
        """Return the recordings of ``item``, and its parts that are none."""
        ...


def importer(name: str) -> Importer:
    """Import an importer; `ParameterError` if there is none of that name, or its module lacks a member."""
    module = IMPORTERS.module(name)
    members = ("TITLE", "LICENCE", "DESCRIPTION", "find", "read")
    if lacking := [member for member in members if not hasattr(module, member)]:
        raise ParameterError(
            f"{module.__file__}: must define {', '.join(members)}, lacks {', '.join(lacking)}"
        )
    return cast("Importer", module)


def importers() -> dict[str, Importer]:
    """Return every importer by its name."""
    return {name: importer(name) for name in IMPORTERS.names()}


LEFT_BEHIND = ("thumbs.db", "desktop.ini", ".bak", ".tmp", "~")
"""Ends of the names of files that nobody means."""


def files_below(folder: Path, suffixes: Iterable[str] | None) -> dict[str, Path]:
    """Return the files below ``folder`` by relative path, numbers in order, without what systems and editors leave.

    ``suffixes`` are the wanted ones; None is all.
    """
    paths = {path.relative_to(folder): path for path in folder.rglob("*")}
    ends = None if suffixes is None else tuple(suffixes)
    return {
        name.as_posix(): paths[name]
        for name in sorted(paths, key=lambda name: natural_key(name.as_posix()))
        if (ends is None or name.name.lower().endswith(ends))
        and not any(part.startswith((".", "~$", "__MACOSX")) for part in name.parts)
        and not name.name.lower().endswith(LEFT_BEHIND)
        and paths[name].is_file()
    }


def check_positive(**options: object) -> None:
    """Raise a `ParameterError` for the first option that is not a finite number above 0."""
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
            raise ParameterError(f"{name} must be a number > 0, got {value!r}")
