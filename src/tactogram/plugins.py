"""Plug-ins: modules that installed packages and further folders add to this package."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from importlib.machinery import PathFinder
from importlib.metadata import entry_points
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

from tactogram.errors import ParameterError


@dataclass(frozen=True)
class PluginGroup:
    """Modules of one kind: a package's own, those of installed packages, and files in further folders.

    Parameters
    ----------
    kind : str
        What a module holds, for errors: ``haptic format``.
    package : str
        Every module and package directly in it is one of the kind, and is called like its file.
    entry_points : str
        Group under which an installed package names its modules: ``name = "my_package.my_module"``.
    variable : str
        Environment variable with further files and folders of files, separated as in PATH.
    """

    kind: str
    package: str
    entry_points: str
    variable: str

    def names(self) -> tuple[str, ...]:
        """Return the names of all modules, sorted; none of them is imported.

        Raises
        ------
        ParameterError
            If two modules have one name, or a folder holds none.
        """
        return tuple(sorted(self._places()))

    def __contains__(self, name: object) -> bool:
        """Return whether there is a module of that name; none is imported."""
        return name in self._own() or name in self._places()

    def module(self, name: str) -> ModuleType:
        """Import a module by its name.

        Raises
        ------
        ParameterError
            If there is none of that name, or it cannot be imported.
        """
        if name in self._own():
            return import_module(f"{self.package}.{name}")
        places = self._places()
        if name not in places:
            raise ParameterError(
                f"{self.kind} must be one of {', '.join(sorted(places))}, or of a file that {self.variable} names, "
                f"got {name!r}"
            )
        return import_plugin(places[name])

    def _own(self) -> set[str]:
        return {found.name for found in iter_modules(import_module(self.package).__path__)}

    def _places(self) -> dict[str, str | Path]:
        """Return what to import, by name: a module's dotted name, or a file."""
        places: dict[str, str | Path] = {name: f"{self.package}.{name}" for name in self._own()}
        for name, place in self._further():
            if places.setdefault(name, place) != place:
                raise ParameterError(f"two {self.kind}s are called {name!r}: {places[name]}, {place}")
        return places

    def _further(self) -> Iterator[tuple[str, str | Path]]:
        yield from _entry_points(self.entry_points, tuple(sys.path))
        for folder in further_folders(self.variable):
            for file in module_files(folder, self.kind):
                yield file.stem, file


def entry_point_modules(group: str) -> list[str]:
    """Return the modules that installed packages name in an entry point group, sorted."""
    return sorted(module for _, module in _entry_points(group, tuple(sys.path)))


def further_folders(variable: str, given: Iterable[Path | str] = ()) -> tuple[Path, ...]:
    """Return the folders that an environment variable names, separated as in PATH, and then those ``given``."""
    named = [text for text in os.environ.get(variable, "").split(os.pathsep) if text]
    return (*map(Path, named), *map(Path, given))


def module_files(given: Path, kind: str) -> list[Path]:
    """Return a file or package itself, and of another folder the files and packages that lie there.

    Raises
    ------
    ParameterError
        If there are none.
    """
    if given.is_file() or (given / "__init__.py").is_file():
        return [given]
    packages = [file.parent for file in given.glob("*/__init__.py")]
    files = [path for path in sorted((*given.glob("*.py"), *packages)) if not path.name.startswith("_")]
    if not files:
        raise ParameterError(f"{given}: must be the file of a {kind} or a folder of such, found none")
    return files


def import_plugin(place: str | Path) -> ModuleType:
    """Import a module by its dotted name, or a file or package by its path.

    Raises
    ------
    ParameterError
        If it cannot be imported, whatever is wrong with it.
    """
    try:
        return import_path(place.absolute()) if isinstance(place, Path) else import_module(place)
    except ParameterError:
        raise
    except Exception as error:
        raise ParameterError(f"{place}: cannot be imported: {type(error).__name__}: {error}") from error


def import_path(path: Path) -> ModuleType:
    """Import a Python file, or a folder with an ``__init__.py``, under its own name, without touching ``sys.path``.

    Parameters
    ----------
    path : Path
        Outside every package.

    Raises
    ------
    ParameterError
        If another module has its name.
    """
    name, file = path.stem, path / "__init__.py" if path.is_dir() else path
    known = sys.modules.get(name)
    if known is not None and _is_from(known, file):
        return known
    if known is not None or PathFinder.find_spec(name) is not None or name in sys.stdlib_module_names:
        raise ParameterError(f"{path}: rename it, {name!r} is the name of another module")
    inside = [str(path)] if path.is_dir() else None
    spec = spec_from_file_location(name, file, submodule_search_locations=inside)
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
    """Return names and modules of a group; ``path`` is ``sys.path``, which decides what is installed."""
    return tuple((point.name, point.value) for point in entry_points(group=group))


def _is_from(module: ModuleType, file: Path) -> bool:
    return module.__file__ is not None and Path(module.__file__).resolve() == file.resolve()
