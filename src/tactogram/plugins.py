"""Plug-ins: modules that installed packages and further folders add to this package."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from importlib.machinery import PathFinder
from importlib.metadata import entry_points
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from pkgutil import iter_modules
from threading import RLock
from types import ModuleType
from typing import Protocol, TypeVar

from tactogram.errors import ParameterError


class Named(Protocol):
    """Value with a name."""

    @property
    def name(self) -> str:
        """Its name."""
        ...


T = TypeVar("T", bound=Named)
_IMPORTING = RLock()
"""Held while a path is imported: another thread must not get a module that is still being executed."""


@dataclass(frozen=True)
class PluginGroup:
    """Modules of one kind: built-in ones, those of installed packages, and files in further folders.

    Parameters
    ----------
    kind : str
        Kind of module, for errors: ``haptic format``.
    package : str
        Package whose direct modules and subpackages are the built-in ones, named after their files.
    entry_points : str
        Group under which an installed package names its modules: ``name = "my_package.my_module"``.
    variable : str
        Environment variable with further files and folders of files, separated as in PATH.
    extra : str
        Extra of this package that brings further modules.
    """

    kind: str
    package: str
    entry_points: str
    variable: str
    extra: str = ""

    def names(self) -> tuple[str, ...]:
        """Return the names of all modules, sorted, without importing them; `ParameterError` if two have one name."""
        return tuple(sorted(self._places()))

    def __contains__(self, name: object) -> bool:
        """Return whether there is a module of that name, without importing it."""
        return name in self._built_in() or name in self._places()

    def module(self, name: str) -> ModuleType:
        """Import a module by its name; `ParameterError` if there is none, or it cannot be imported."""
        if name in self._built_in():
            return import_module(f"{self.package}.{name}")
        places = self._places()
        if name not in places:
            named = f"{self.variable} names files of others"
            remedy = "; ".join(filter(None, [self.further_extra(), named]))
            raise ParameterError.one_of(self.kind, sorted(places), name, remedy=remedy)
        return import_plugin(places[name])

    def further_extra(self) -> str:
        """Return how to install the extra that brings further modules; empty if there is none, or it is installed."""
        if not self.extra or _entry_points(self.entry_points, tuple(sys.path)):
            return ""
        return f"further {self.kind}s come with an extra: pip install 'tactogram[{self.extra}]'"

    def definition(self, name: str, attribute: str, kind: type[T]) -> T:
        """Return the ``attribute`` of a module; `ParameterError` if it is not a ``kind`` with the module's name."""
        module = self.module(name)
        value = getattr(module, attribute, None)
        if not isinstance(value, kind) or value.name != name:
            raise ParameterError(
                f"{module.__file__}: must define {attribute}, a {kind.__name__} called {name!r}"
            )
        return value

    def _built_in(self) -> set[str]:
        return {module.name for module in iter_modules(import_module(self.package).__path__)}

    def _places(self) -> dict[str, str | Path]:
        """Return by name what to import: a module's dotted name, or a file."""
        places: dict[str, str | Path] = {name: f"{self.package}.{name}" for name in self._built_in()}
        files: list[tuple[str, str | Path]] = [
            (file.stem, file)
            for folder in further_folders(self.variable)
            for file in module_files(folder, self.kind)
        ]
        for name, source in (*_entry_points(self.entry_points, tuple(sys.path)), *files):
            if places.setdefault(name, source) != source:
                raise ParameterError(f"two {self.kind}s are called {name!r}: {places[name]}, {source}")
        return places


def entry_point_modules(group: str) -> list[str]:
    """Return the modules that installed packages name in an entry point group, sorted."""
    return sorted(module for _, module in _entry_points(group, tuple(sys.path)))


def further_folders(variable: str, more: Iterable[Path | str] = ()) -> tuple[Path, ...]:
    """Return the folders in an environment variable, separated as in PATH, and then ``more``."""
    named = [text for text in os.environ.get(variable, "").split(os.pathsep) if text]
    return (*map(Path, named), *map(Path, more))


def module_files(path: Path, kind: str) -> list[Path]:
    """Return a file or package itself, and of another folder its files and packages; `ParameterError` if none."""
    if path.is_file() or (path / "__init__.py").is_file():
        return [path]
    packages = [file.parent for file in path.glob("*/__init__.py")]
    files = [file for file in sorted((*path.glob("*.py"), *packages)) if not file.name.startswith("_")]
    if not files:
        raise ParameterError(f"{path}: must be the file of a {kind} or a folder of such files, found none")
    return files


def import_plugin(place: str | Path) -> ModuleType:
    """Import a dotted name, or a file or package by its path; `ParameterError` if that fails for whatever reason."""
    try:
        return import_path(place.absolute()) if isinstance(place, Path) else import_module(place)
    except ParameterError:
        raise
    except Exception as error:
        raise ParameterError(f"{place}: cannot be imported: {type(error).__name__}: {error}") from error


def import_path(path: Path) -> ModuleType:
    """Import a Python file, or a folder with an ``__init__.py``, by its name without changing ``sys.path``.

    It must lie outside of every package; another module of its name is a `ParameterError`.
    """
    with _IMPORTING:
        return _import_path(path)


def _import_path(path: Path) -> ModuleType:
    name, file = path.stem, path / "__init__.py" if path.is_dir() else path
    loaded = sys.modules.get(name)
    if loaded is not None and loaded.__file__ and Path(loaded.__file__).resolve() == file.resolve():
        return loaded
    if loaded is not None or PathFinder.find_spec(name) is not None or name in sys.stdlib_module_names:
        raise ParameterError(f"{path}: rename it, {name!r} is the name of another module")
    submodules = [str(path)] if path.is_dir() else None
    spec = spec_from_file_location(name, file, submodule_search_locations=submodules)
    if spec is None or spec.loader is None:
        raise ParameterError(f"{path}: must be a Python file or a folder with an __init__.py")
    module = module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


@lru_cache(maxsize=32)
def _entry_points(group: str, path: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """Return names and modules of a group; ``path``, which is ``sys.path``, is a key of the cache."""
    return tuple((point.name, point.value) for point in entry_points(group=group))
