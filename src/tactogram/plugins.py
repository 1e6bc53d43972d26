"""Plug-ins: modules that installed packages and further folders add to this package."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from importlib.machinery import PathFinder
from importlib.metadata import entry_points
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

from tactogram.errors import ParameterError


def entry_point_modules(group: str) -> list[str]:
    """Return the modules that installed packages name in an entry point group, sorted."""
    return sorted(point.value for point in entry_points(group=group))


def further_folders(variable: str, given: Iterable[Path | str] = ()) -> tuple[Path, ...]:
    """Return the folders that an environment variable names, separated as in PATH, and then those ``given``."""
    named = [text for text in os.environ.get(variable, "").split(os.pathsep) if text]
    return (*map(Path, named), *map(Path, given))


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


def _is_from(module: ModuleType, file: Path) -> bool:
    return module.__file__ is not None and Path(module.__file__).resolve() == file.resolve()
