"""Texture sources of the page Touch: materials of runs, kept results and files, found and loaded."""

from __future__ import annotations

import json
import math
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args

import numpy as np

from tactogram.errors import DataError, ParameterError
from tactogram.model import TextureMapModel
from tactogram.rendering.streaming.texture_table import TextureTable
from tactogram.signal import Image, Signal
from tactogram.signal.io import read_metadata, read_signal
from tactogram.signal.io.files import READABLE
from tactogram.signal.synthesis import synthesise
from tactogram.signal.texture_map import TextureMap
from tactogram.studio.pages.touch.offers import CAN_BE_GIVEN, TextureChoice, TextureOrigin, offers_of
from tactogram.studio.pages.touch.tables import (
    ASSUMED_SPEED_MM_S,
    TouchTexture,
    table_of_map,
    table_of_signal,
)
from tactogram.studio.workspace.folder import Workspace
from tactogram.studio.workspace.shelf import ResultArchive

if TYPE_CHECKING:
    from tactogram.workflows.training.loaded_run import LoadedRun

T = TypeVar("T")
TextureLayout = Literal["auto", "table", "path", "x", "y"]

LAID_S = 6.0
"""How much of a texture is laid out along the way, s; longer than the ear remembers a loop of noise."""
LARGEST_FILE = 200_000_000
MOST_TABLES, MOST_RUNS = 64, 3
"""That are remembered."""
RATES = (8000.0, 192_000.0)


@dataclass(frozen=True)
class TextureRequest:
    """One texture that the page asks for.

    Parameters
    ----------
    where : {"run", "kept", "file"}
    of : str
        Folder of the run or the file, relative to the workspace; or the id of a kept result.
    material : str
        Of a run.
    speed_mm_s : float, optional
        At which a signal over time was recorded, or shall be made, mm/s.
    lay : {"auto", "table", "path", "x", "y"}
        What it follows: a table over speed and force, or the place of the finger.
    axes : str
    seed : int
    rate : float
        Of the browser's audio, Hz.

    Raises
    ------
    ParameterError
        If a value is out of range.
    """

    where: TextureOrigin
    of: str
    material: str = ""
    speed_mm_s: float | None = None
    lay: TextureLayout = "auto"
    axes: str = "dft321"
    seed: int = 0
    rate: float = 48_000.0

    def __post_init__(self) -> None:
        if self.where not in get_args(TextureOrigin):
            raise ParameterError(
                f"where must be one of {', '.join(get_args(TextureOrigin))}, got {self.where[:40]!r}"
            )
        if self.lay not in get_args(TextureLayout):
            raise ParameterError(
                f"lay must be one of {', '.join(get_args(TextureLayout))}, got {self.lay[:40]!r}"
            )
        if not RATES[0] <= self.rate <= RATES[1]:
            raise ParameterError(f"rate must be {RATES[0]:g} to {RATES[1]:g} Hz, got {self.rate:g}")
        if self.speed_mm_s is not None and not 1 <= self.speed_mm_s <= 2000:
            raise ParameterError(f"speed must be 1 to 2000 mm/s, got {self.speed_mm_s:g}")
        if not 0 <= self.seed < 2**31:
            raise ParameterError(f"seed must be 0 to {2**31 - 1}, got {self.seed}")
        if not self.of or len(self.of) > 1000 or len(self.material) > 200 or len(self.axes) > 40:
            raise ParameterError("say what is to be felt: a run, a kept result or a file")


class TouchSources:
    """Textures of a workspace and their tables, cached.

    Parameters
    ----------
    workspace : Workspace
    shelf : Shelf
    """

    def __init__(self, workspace: Workspace, shelf: ResultArchive) -> None:
        self._workspace, self._shelf = workspace, shelf
        self._tables = _ValueCache(MOST_TABLES)
        self._runs = _ValueCache(MOST_RUNS)

    def offers(self) -> list[TextureChoice]:
        """Return what can be felt: runs' materials (newest run first), kept signals, files."""
        return offers_of(self._workspace, self._shelf)

    def table(self, asked: TextureRequest) -> TouchTexture:
        """Return the table of what was asked for.

        Raises
        ------
        TactogramError
            If it is not there, lies outside of the workspace, or cannot be felt.
        """
        path = self._place(asked)
        return self._tables.get((asked, _stamp(path)), lambda: self._made(asked, path))

    def signal(self, asked: TextureRequest) -> tuple[Signal, float | None]:
        """Return some seconds of what was asked for, and the speed at which they were recorded or made.

        Raises
        ------
        TactogramError
            As for `table`.
        """
        path = self._place(asked)
        if asked.where == "run":
            run = self._loaded(path)
            surface = _map_of(run, asked.material)
            return _generated(run, asked) if surface is None else self._laid(surface, asked)
        return self._recorded(asked, path)

    def photograph(self, asked: TextureRequest) -> tuple[Image, bool] | None:
        """Return a picture of a run's material out of its data, and whether that was simulated; None without one."""
        if asked.where != "run":
            return None
        from tactogram.datasets import open_store

        store_path = self._store_of(self._place(asked))
        if store_path is None:
            return None
        store = open_store(store_path)
        for key in store.photographs_of(asked.material):
            return store.photograph(key), store.simulated
        for info in store.index:
            if info.material == asked.material and (image := store.image(info.id)) is not None:
                return image, store.simulated
        return None

    # -- loading -----------------------------------------------------------------------------------------

    def _place(self, asked: TextureRequest) -> Path:
        if asked.where == "kept":
            return self._shelf.get(asked.of).folder
        path = self._workspace.inside(asked.of)
        if asked.where == "file" and not path.is_file():
            raise DataError(f"{asked.of}: there is no such file in the workspace")
        if asked.where == "run" and not path.is_dir():
            raise DataError(f"{asked.of}: there is no such run in the workspace")
        return path

    def _store_of(self, run: Path) -> Path | None:
        """Return the store that a run learned from, if it lies in the workspace, there or elsewhere."""
        try:
            data = json.loads((run / "data.json").read_text(encoding="utf-8"))
            wanted = self._workspace.folder / str(data["path"])
            if (
                wanted.resolve().is_relative_to(self._workspace.folder)
                and (wanted / "dataset.json").is_file()
            ):
                return wanted
            return next((path for path in self._workspace.stores() if _hash_of(path) == data["sha256"]), None)
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def _made(self, asked: TextureRequest, path: Path) -> TouchTexture:
        if asked.where == "run":
            run = self._loaded(path)
            surface = _map_of(run, asked.material)
            if surface is not None and _by_table(surface, asked):
                return table_of_map(
                    asked.material, surface, rate=asked.rate, axes=asked.axes, simulated=run.simulated
                )
            simulated, name = run.simulated, asked.material
        else:
            name = self._shelf.get(asked.of).title if asked.where == "kept" else path.stem
            simulated = bool(self._facts(asked, path).get("simulated", False))
        signal, speed = self.signal(asked)
        return table_of_signal(
            name,
            signal,
            rate=asked.rate,
            speed_mm_s=speed,
            along=asked.lay if asked.lay in ("x", "y") else "path",
            axes=asked.axes if len(signal.axes) > 1 else signal.axes[0],
            simulated=simulated,
        )

    def _loaded(self, path: Path) -> LoadedRun:
        def load() -> LoadedRun:
            from tactogram.workflows.training.loaded_run import load_run

            return load_run(path)

        return self._runs.get((path, _stamp(path)), load)

    def _laid(self, surface: TextureMap, asked: TextureRequest) -> tuple[Signal, float | None]:
        """Return some seconds of an autoregressive texture at a speed, and that speed."""
        table = TextureTable(surface, axis=asked.axes)
        own = float(np.median(table.grid.speeds)) if surface.known[0] else ASSUMED_SPEED_MM_S
        speed = own if asked.speed_mm_s is None else asked.speed_mm_s
        force = float(np.median(table.grid.forces))
        return synthesise(table.at(speed, force), LAID_S, seed=asked.seed), speed

    def _recorded(self, asked: TextureRequest, path: Path) -> tuple[Signal, float | None]:
        if asked.where == "kept":
            signal = self._shelf.get(asked.of).signal()
        elif path.suffix.lower() not in READABLE:
            raise ParameterError(f"{asked.of}: expected a file of {', '.join(READABLE)}, got {path.suffix!r}")
        elif path.stat().st_size > LARGEST_FILE:
            raise ParameterError(f"{asked.of}: larger than {LARGEST_FILE // 1_000_000} MB; cut it first")
        else:
            signal = read_signal(path)
        said = _speed_in(self._facts(asked, path))
        return signal, said if asked.speed_mm_s is None else asked.speed_mm_s

    def _facts(self, asked: TextureRequest, path: Path) -> dict[str, Any]:
        if asked.where == "kept":
            return dict(self._shelf.get(asked.of).facts)
        return read_metadata(path) if path.suffix.lower() in READABLE else {}


class _ValueCache:
    """The last values that were made, each once however many ask for it at the same time."""

    def __init__(self, most: int) -> None:
        self._most, self._kept = most, OrderedDict[Any, Any]()
        self._lock, self._making = threading.Lock(), OrderedDict[Any, threading.Lock]()

    def get(self, key: Any, make: Callable[[], T]) -> T:
        with self._lock:
            one = self._making.setdefault(key, threading.Lock())
        with one:
            with self._lock:
                if key in self._kept:
                    self._kept.move_to_end(key)
                    found: T = self._kept[key]
                    return found
            made = make()
            with self._lock:
                self._kept[key] = made
                while len(self._kept) > self._most:
                    gone, _ = self._kept.popitem(last=False)
                    self._making.pop(gone, None)
            return made


def _map_of(run: LoadedRun, material: str) -> TextureMap | None:
    """Return a material's autoregressive models; None for a run of another kind."""
    if material not in run.kind.materials:
        raise ParameterError(
            f"{run.run.name} has no material {material[:60]!r}; it has {', '.join(run.kind.materials)}"
        )
    if not isinstance(run.model, TextureMapModel):
        return None
    return run.model.maps[run.kind.materials.index(material)]


def _by_table(surface: TextureMap, asked: TextureRequest) -> bool:
    """Tell whether models are played as a table: where they know more than one speed, unless asked otherwise."""
    if asked.lay != "auto":
        return asked.lay == "table"
    known = surface.known[0]
    return len(np.unique(surface.conditions[:, 0])) > 1 if known else asked.speed_mm_s is None


def _generated(run: LoadedRun, asked: TextureRequest) -> tuple[Signal, float | None]:
    """Return what a run makes of a material, and the speed it was asked for."""
    from tactogram.workflows.generation.generate import generate

    if lacking := set(run.facts.needs) - CAN_BE_GIVEN:
        raise ParameterError(
            f"{run.run.name} needs {', '.join(sorted(lacking))}: make a result on the page Make, keep it, and feel that"
        )
    condition: dict[str, Any] = {"material": {asked.material: 1.0}}
    if "speed_mm_s" in (*run.facts.needs, *run.facts.takes):
        condition["speed_mm_s"] = asked.speed_mm_s or ASSUMED_SPEED_MM_S
    seconds = LAID_S if run.kind.domain == "time" else None
    made = next(iter(generate(run, condition, seconds=seconds, seed=asked.seed)))
    if not isinstance(made, Signal):
        raise ParameterError(f"{run.run.name}: {run.facts.name} makes images; there is nothing to feel")
    return made, condition.get("speed_mm_s", asked.speed_mm_s)


def _speed_in(facts: dict[str, Any]) -> float | None:
    """Return the speed that a file or a kept result says of itself."""
    condition = facts.get("condition")
    for values in (facts, condition if isinstance(condition, dict) else {}):
        value = values.get("speed_mm_s")
        if isinstance(value, int | float) and math.isfinite(value) and value > 0:
            return float(value)
    return None


def _stamp(path: Path) -> tuple[int, ...]:
    """Return what changes when a run, a kept result or a file changes."""
    inner = [path, path / "model.safetensors", path / "facts.json"]
    return tuple(file.stat().st_mtime_ns for file in inner if file.exists())


def _hash_of(store: Path) -> str:
    try:
        return str(json.loads((store / "dataset.json").read_text(encoding="utf-8")).get("sha256", ""))
    except (OSError, ValueError):
        return ""
