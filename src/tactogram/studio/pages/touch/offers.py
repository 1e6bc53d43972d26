"""Textures offered by the page Touch: materials of runs, kept results, files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tactogram import models
from tactogram.errors import TactogramError
from tactogram.signal.io.files import READABLE
from tactogram.studio.workspace.folder import MOST_FOLDERS, RUN, STORE, Workspace
from tactogram.studio.workspace.shelf import ResultArchive
from tactogram.text_files import read_json, read_toml

TextureOrigin = Literal["run", "kept", "file"]

MOST_FILES = 300
"""Listed files; others can be named by their path."""
SUPPORTED = {"material", "speed_mm_s", "force_n"}
"""Conditions that the page can set; results of models that need more are generated on the page Make and kept."""


@dataclass(frozen=True)
class TextureChoice:
    """A texture to choose, listed under ``group``; ``where``, ``of`` and ``material`` as of `TextureRequest`."""

    where: TextureOrigin
    of: str
    material: str
    title: str
    group: str
    simulated: bool = False


def texture_choices(workspace: Workspace, shelf: ResultArchive) -> list[TextureChoice]:
    """Return the materials of runs (newest run first), kept signals and files, without loading them."""
    return [*_of_runs(workspace), *_of_shelf(shelf), *_of_files(workspace)]


def _of_runs(workspace: Workspace) -> Iterator[TextureChoice]:
    for folder in workspace.finished_runs():
        try:
            facts = read_json(folder / "model.json")
            model = read_toml(folder / RUN)["model"]
            found = models.find(model)
            kind = facts["kind"]
            materials, simulated = list(kind["materials"]), bool(kind["simulated"])
        except (KeyError, TypeError, TactogramError):
            continue  # damaged, or its model is not installed: the page Reports says so
        if found.task == "generation" and found.gives == "signal" and set(found.needs) <= SUPPORTED:
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
    """Yield signal files outside of runs, stores and the studio's own folder."""
    count = 0
    for seen, (text, folders, files) in enumerate(os.walk(workspace.folder)):
        folder = Path(text)
        if seen >= MOST_FOLDERS:
            return
        inside = folder.relative_to(workspace.folder).parts
        skip = len(inside) > 4 or {RUN, STORE} & set(files)
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
