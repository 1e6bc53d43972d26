"""Textures offered by the page Touch: materials of runs, kept results, files."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tactogram import models
from tactogram.errors import TactogramError
from tactogram.signal.io.files import READABLE
from tactogram.studio.workspace.folder import MOST_FOLDERS, Workspace
from tactogram.studio.workspace.shelf import ResultArchive

TextureOrigin = Literal["run", "kept", "file"]

MOST_FILES = 300
"""That are offered; a further one is named by its path."""
CAN_BE_GIVEN = {"material", "speed_mm_s", "force_n"}
"""Conditions that the page can give a model; what needs more is made elsewhere and kept."""


@dataclass(frozen=True)
class TextureChoice:
    """A texture that can be chosen.

    Parameters
    ----------
    where, of, material : see `tactogram.studio.pages.touch.sources.TextureRequest`
    title : str
        What people read.
    group : str
        What it is listed under: the run, kept results, files.
    simulated : bool
        Whether it was learned or recorded from a simulation, as far as is known.
    """

    where: TextureOrigin
    of: str
    material: str
    title: str
    group: str
    simulated: bool = False


def offers_of(workspace: Workspace, shelf: ResultArchive) -> list[TextureChoice]:
    """Return what can be felt: runs' materials (newest run first), kept signals, files; nothing is loaded."""
    return [*_of_runs(workspace), *_of_shelf(shelf), *_of_files(workspace)]


def _of_runs(workspace: Workspace) -> Iterator[TextureChoice]:
    for folder in workspace.finished_runs():
        try:
            facts = json.loads((folder / "model.json").read_text(encoding="utf-8"))
            model = tomllib.loads((folder / "recipe.toml").read_text(encoding="utf-8"))["model"]
            found = models.find(model)
            kind = facts["kind"]
            materials, simulated = list(kind["materials"]), bool(kind["simulated"])
        except (OSError, ValueError, KeyError, TypeError, TactogramError):
            continue  # broken, or of a model that is not installed: the page Reports says what
        if found.task == "generation" and found.gives == "signal" and set(found.needs) <= CAN_BE_GIVEN:
            name = workspace.name_of(folder)
            for material in materials:
                yield TextureChoice("run", name, str(material), str(material), f"{name} ({model})", simulated)


def _of_shelf(shelf: ResultArchive) -> Iterator[TextureChoice]:
    for made in shelf.all():
        if not made.is_image:
            yield TextureChoice(
                "kept", made.id, "", made.title, "Kept results", bool(made.facts.get("simulated", False))
            )


def _of_files(workspace: Workspace) -> Iterator[TextureChoice]:
    """Yield signal files that lie neither in a run nor in what the studio keeps itself."""
    count = 0
    for seen, (text, folders, files) in enumerate(os.walk(workspace.folder)):
        folder = Path(text)
        if seen >= MOST_FOLDERS:
            return
        inside = folder.relative_to(workspace.folder).parts
        skip = len(inside) > 4 or {"recipe.toml", "dataset.json"} & set(files)
        folders[:] = sorted(
            name
            for name in folders
            if not skip
            and not name.startswith(".")
            and not (not inside and name == workspace.studio_folder.name)
        )
        if skip:
            continue
        for name in sorted(files):
            if Path(name).suffix.lower() in READABLE and Path(name).suffix.lower() != ".txt":
                count += 1
                if count > MOST_FILES:
                    return
                of = workspace.name_of(folder / name)
                yield TextureChoice("file", of, "", of, "Files")
