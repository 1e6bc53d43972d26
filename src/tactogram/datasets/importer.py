"""Importer protocol: from the files of one data set to recordings.

An importer is a module of this package, found by looking and registered nowhere. It offers

- facts: ``NAME`` (the word after ``data import``), ``TITLE``, ``LICENCE``, ``DESCRIPTION`` (what is read,
  to what units, and which parts were checked on real files), all ``str``;
- ``find(folder: Path) -> list[ImportItem]``: a cheap look at names and tables, in an order that stays;
  it opens no signal;
- where it has options, they are keyword-only parameters of ``find``, each with its default;
- ``read(item: ImportItem) -> list[Recording]``: the recordings of one item. It runs in another process, so that
  all cores read; what it raises as a `TactogramError` is told with the item's name;
- where there are any, ``photographs(folder: Path) -> list[ImportedPhotograph]``: photographs that belong to a
material, not to
  one recording, told the options of ``find`` that it has too. The import opens them, one at a time;
- where people rated what is imported, ``ratings(folder: Path) -> Ratings | None``; what was rated and is not among
  the recordings is left out.

``LICENCE`` says what the source states; where it states none, ``"not stated"``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from tactogram.datasets.recording import Recording
from tactogram.errors import ParameterError


@dataclass(frozen=True)
class ImportItem:
    """Unit of reading: one recording, or one file that holds several.

    Parameters
    ----------
    name : str
        Path relative to the imported folder, with ``/``; `Recording.source` starts with it, errors name it.
    paths : tuple of Path
        The files it needs. One that is missing or empty is an error that names it, before `read` is called.
    info : mapping
        What `find` already knows, for `read`: anything that can be pickled.
    image : Path, optional
        The photograph of every recording of this item that brings none of its own. Many items may share one:
        it is opened and stored once, by the import, not by `read`.
    image_width_mm : float, optional
        How many mm of surface the width of that photograph shows.
    """

    name: str
    paths: tuple[Path, ...]
    info: Mapping[str, Any] = field(default_factory=dict)
    image: Path | None = None
    image_width_mm: float | None = None


@dataclass(frozen=True)
class ImportedPhotograph:
    """A photograph of a material.

    Parameters
    ----------
    name : str
        Path relative to the imported folder, with ``/``.
    path : Path
    material : str
        What it shows; there need be no recording of it.
    width_mm : float, optional
        How many mm of surface its width shows.
    """

    name: str
    path: Path
    material: str
    width_mm: float | None = None


class Importer(Protocol):
    """Protocol of an importer module."""

    NAME: str
    TITLE: str
    LICENCE: str
    DESCRIPTION: str

    def find(self, folder: Path) -> list[ImportItem]:
        """Return what is to be read in ``folder``, in a stable order; `DataError` if it is not this set."""
        ...

    def read(self, item: ImportItem) -> list[Recording]:
        """Return the recordings of ``item``."""
        ...


def check_positive(**options: object) -> None:
    """Refuse an importer's options, by name, that are not finite numbers above 0.

    Raises
    ------
    ParameterError
        Naming the first.
    """
    for name, value in options.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
            raise ParameterError(f"{name} must be a number > 0, got {value!r}")
