"""Textures offered by the page Touch: materials of runs, kept results, files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tactogram import models
from tactogram.errors import TactogramError
from tactogram.text_files import read_json, read_toml
from tactogram_studio.workspace.folder import RUN, STORE, Workspace
from tactogram_studio.workspace.shelf import ResultArchive

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
    names = [
        workspace.name_of(path)
        for path in workspace.signal_files()
        if not path.is_relative_to(workspace.studio_folder)
        and not any(
            (folder / name).is_file() for folder in _folders(workspace, path) for name in (RUN, STORE)
        )
    ]
    for name in names[:MOST_FILES]:
        yield TextureChoice("file", name, "", name, "Files")


def _folders(workspace: Workspace, path: Path) -> Iterator[Path]:
    return (folder for folder in path.parents if folder.is_relative_to(workspace.folder))
