"""Texture sources of the page Touch: materials of runs, kept results and files, offered and loaded."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field

from tactogram.errors import DataError, ParameterError
from tactogram.signal import (
    Image,
    ModulatedNoise,
    NoiseMap,
    Signal,
    TextureMap,
    synthesise,
    synthesise_modulated_noise,
)
from tactogram.signal.io import READABLE, USUAL, read_metadata, read_signal
from tactogram.validation import FrozenModel
from tactogram_playback import TextureSettings, texture_of_map
from tactogram_studio.signals.registry import ValueCache
from tactogram_studio.touch.photographs import relief_of
from tactogram_studio.touch.tables import (
    ASSUMED_SPEED_MM_S,
    TouchTexture,
    table_of_map,
    table_of_signal,
)
from tactogram_studio.workspace.folder import RUN, STORE, Workspace
from tactogram_studio.workspace.runs import LOCK, RunCatalogue
from tactogram_studio.workspace.shelf import ResultArchive

if TYPE_CHECKING:
    from tactogram.workflows import LoadedRun

TextureOrigin = Literal["run", "kept", "file"]
TextureLayout = Literal["auto", "table", "path", "x", "y"]

MOST_FILES = 300
"""Listed files; others can be named by their path."""
SUPPORTED = {"material", "speed_mm_s", "force_n"}
"""Conditions that the page can set; results of models that need more are generated on the page Make and kept."""

LAID_S = 6.0
"""Length of a generated texture, s; longer than the ear remembers a loop of noise."""
LARGEST_FILE = 200_000_000
MOST_TABLE_BYTES = 32 * 2**20
"""In the cache."""


class TextureRequest(FrozenModel):
    """Request for a texture.

    ``of`` is the folder of a run or a file, relative to the workspace, or the id of a kept result; ``material`` one of
    a run. ``speed_mm_s`` is the speed of a recording over time, or of a generated signal; ``lay`` whether the texture
    follows speed and force (table) or the position of the finger; ``rate`` that of the browser's audio, Hz.
    """

    where: TextureOrigin
    of: Annotated[str, Field(min_length=1, max_length=1000)]
    material: Annotated[str, Field(max_length=200)] = ""
    speed_mm_s: Annotated[float, Field(ge=1, le=2000)] | None = None
    lay: TextureLayout = "auto"
    axes: Annotated[str, Field(max_length=40)] = "dft321"
    seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    rate: Annotated[float, Field(ge=8000, le=192_000)] = 48_000.0


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
    for run in RunCatalogue(workspace).own():
        if run.model.gives == "signal" and set(run.model.needs) <= SUPPORTED:
            group = f"{run.name} ({run.model.name})"
            for material in run.kind.materials:
                yield TextureChoice("run", run.name, material, material, group, run.kind.simulated)


def _of_shelf(shelf: ResultArchive) -> Iterator[TextureChoice]:
    for kept in shelf.all():
        if not kept.is_image:
            yield TextureChoice(
                "kept", kept.id, "", kept.title, "Kept results", bool(kept.facts.get("simulated", False))
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


class TouchSources:
    """Textures of a workspace and their tables, cached."""

    def __init__(self, workspace: Workspace, shelf: ResultArchive) -> None:
        self._workspace, self._shelf = workspace, shelf
        self._runs = RunCatalogue(workspace)
        self._tables: ValueCache[TouchTexture] = ValueCache(MOST_TABLE_BYTES, lambda table: table.nbytes)

    def table(self, request: TextureRequest) -> TouchTexture:
        """Return the table of a texture; `TactogramError` if it does not exist in the workspace, or cannot be felt."""
        path = self._place(request)
        return self._tables.get((request, _stamp(path)), lambda: self._made(request, path))

    def title(self, request: TextureRequest) -> str:
        """Return the material, the title of a kept result, or the file."""
        return (
            self._shelf.get(request.of).title if request.where == "kept" else request.material or request.of
        )

    def signal(self, request: TextureRequest) -> tuple[Signal, float | None]:
        """Return some seconds of a texture and the speed of their recording or generation; errors as of `table`."""
        path = self._place(request)
        if request.where == "run":
            run = self._loaded(request)
            surface = _map_of(run, request.material)
            return _generated(run, request) if surface is None else self._laid(surface, request)
        return self._recorded(request, path)

    def photograph(self, request: TextureRequest) -> tuple[Image, bool] | None:
        """Return a picture of a run's material from its data, and whether it is simulated; None if there is none.

        Of a kept relief, the photograph that it was drawn from, unless it is laid along the finger's path or downwards.
        """
        if request.where == "kept" and request.lay in ("auto", "x"):
            kept = self._shelf.get(request.of)
            drawn_from = kept.photograph()
            return None if drawn_from is None else (drawn_from, bool(kept.facts.get("simulated")))
        if request.where != "run":
            return None
        store = self._runs.store_of(self._runs.get(request.of))
        if store is None:
            return None
        for key in store.photographs_of(request.material):
            return store.photograph(key), store.simulated
        for info in store.index:
            if info.material == request.material and (image := store.image(info.id)) is not None:
                return image, store.simulated
        return None

    def _place(self, request: TextureRequest) -> Path:
        if request.where == "kept":
            return self._shelf.get(request.of).folder
        if request.where == "run":
            return self._runs.get(request.of).folder
        path = self._workspace.inside(request.of)
        if not path.is_file():
            raise DataError(request.of, "no such file in the workspace")
        return path

    def _made(self, request: TextureRequest, path: Path) -> TouchTexture:
        if request.where == "run":
            run = self._loaded(request)
            surface = _map_of(run, request.material)
            if surface is not None and _by_table(surface, request):
                return table_of_map(
                    request.material, surface, rate=request.rate, axes=request.axes, simulated=run.simulated
                )
            simulated, name = run.simulated, request.material
        else:
            name = self._shelf.get(request.of).title if request.where == "kept" else path.stem
            facts = self._facts(request, path)
            simulated, limited = bool(facts.get("simulated", False)), facts.get("limited", ())
            if (drawn_from := self.photograph(request)) is not None:
                return table_of_signal(
                    name,
                    relief_of(drawn_from[0]),
                    rate=request.rate,
                    along="x",
                    axes="slope",
                    periodic=True,
                    simulated=simulated,
                    limited=[
                        "drawn from the brightness along the marked line, felt at any height of the finger: a design, "
                        "no prediction of how the material feels"
                    ],
                )
        signal, speed = self.signal(request)
        if request.where == "run":
            from tactogram.workflows import limits

            limited = map(str, limits(run, {"material": request.material, "speed_mm_s": speed}))
        return table_of_signal(
            name,
            signal,
            rate=request.rate,
            speed_mm_s=speed,
            along=request.lay if request.lay in ("x", "y") else "path",
            axes=request.axes if len(signal.axes) > 1 else signal.axes[0],
            simulated=simulated,
            limited=limited,
        )

    def _loaded(self, request: TextureRequest) -> LoadedRun:
        return self._runs.load(self._runs.get(request.of))

    def _laid(self, surface: TextureMap | NoiseMap, request: TextureRequest) -> tuple[Signal, float | None]:
        """Return some seconds of models over speed and force, and their speed."""
        table = texture_of_map("", surface, TextureSettings(request.rate, 1, request.axes)).table
        own = float(np.median(table.grid.speeds)) if surface.has_conditions[0] else ASSUMED_SPEED_MM_S
        speed = own if request.speed_mm_s is None else request.speed_mm_s
        model = table.at(speed, float(np.median(table.grid.forces)))
        from tactogram.training import surface_seed

        seed = surface_seed(request.seed, {"material": request.material})
        if isinstance(model, ModulatedNoise):
            return synthesise_modulated_noise(model, LAID_S, seed=seed), speed
        return synthesise(model, LAID_S, seed=seed), speed

    def _recorded(self, request: TextureRequest, path: Path) -> tuple[Signal, float | None]:
        if request.where == "kept":
            signal = self._shelf.get(request.of).signal()
        elif not path.name.lower().endswith(READABLE):
            raise ParameterError(f"{request.of}: expected a file of {USUAL}, got {path.suffix!r}")
        elif path.stat().st_size > LARGEST_FILE:
            raise ParameterError(f"{request.of}: larger than {LARGEST_FILE // 1_000_000} MB; cut it first")
        else:
            signal = read_signal(path)
        return signal, request.speed_mm_s or _speed_in(self._facts(request, path))

    def _facts(self, request: TextureRequest, path: Path) -> dict[str, Any]:
        if request.where == "kept":
            return dict(self._shelf.get(request.of).facts)
        return read_metadata(path) if path.name.lower().endswith(READABLE) else {}


def _map_of(run: LoadedRun, material: str) -> TextureMap | NoiseMap | None:
    """Return a material's models over speed and force; None if the run has no such models."""
    if material not in run.kind.materials:
        raise ParameterError(
            f"{run.run.name} has no material {material[:60]!r}; it has {', '.join(run.kind.materials)}"
        )
    return run.model.maps[run.kind.materials.index(material)] if run.model.maps else None


def _by_table(surface: TextureMap | NoiseMap, request: TextureRequest) -> bool:
    """Return whether models follow speed and force: by default if they know more than one speed."""
    if request.lay != "auto":
        return request.lay == "table"
    known = surface.has_conditions[0]
    return len(np.unique(surface.conditions[:, 0])) > 1 if known else request.speed_mm_s is None


def _generated(run: LoadedRun, request: TextureRequest) -> tuple[Signal, float | None]:
    from tactogram.workflows import generate

    if lacking := set(run.facts.needs) - SUPPORTED:
        raise ParameterError(
            f"{run.run.name} needs {', '.join(sorted(lacking))}: generate a result on the page Make and keep it"
        )
    condition: dict[str, Any] = {"material": {request.material: 1.0}}
    if "speed_mm_s" in run.facts.conditions:
        condition["speed_mm_s"] = request.speed_mm_s or ASSUMED_SPEED_MM_S
    seconds = LAID_S if run.kind.domain == "time" else None
    with LOCK:
        content = next(iter(generate(run, condition, seconds=seconds, seed=request.seed)))
    if not isinstance(content, Signal):
        raise ParameterError(f"{run.run.name}: {run.facts.name} generates images, which cannot be felt")
    return content, condition.get("speed_mm_s", request.speed_mm_s)


def _speed_in(facts: dict[str, Any]) -> float | None:
    """Return the speed in the facts of a file or a kept result."""
    condition = facts.get("condition")
    for values in (facts, condition if isinstance(condition, dict) else {}):
        value = values.get("speed_mm_s")
        if isinstance(value, int | float) and math.isfinite(value) and value > 0:
            return float(value)
    return None


def _stamp(path: Path) -> tuple[int, ...]:
    """Return a key that changes with a run, a kept result or a file."""
    inner = [path, path / "model.safetensors", path / "facts.json"]
    return tuple(file.stat().st_mtime_ns for file in inner if file.exists())
