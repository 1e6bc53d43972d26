"""Catalogue of study designs, discovered in the package, in installed packages and in folders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from importlib import import_module
from inspect import isabstract
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

from tactogram.errors import ParameterError
from tactogram.plugins import entry_point_modules, further_folders, import_plugin, module_files
from tactogram_study.designs.design import Design, MarginScale

ENTRY_POINTS = "tactogram.designs"
"""Entry point group of an installed package's modules with designs: ``tapping = "my_package.tapping"``."""
FOLDERS_VARIABLE = "TACTOGRAM_DESIGNS"
"""Environment variable with files and folders of further designs, separated as in PATH."""
PACKAGE = __name__.rpartition(".")[0]


def designs() -> Mapping[str, type[Design]]:
    """Return every design by kind: those of this package, of installed ones, and of ``TACTOGRAM_DESIGNS``.

    Raises `ParameterError` if a file cannot be imported or has no design, or two designs share a kind, a margin or a
    power table.
    """
    return _designs(tuple(folder.resolve() for folder in further_folders(FOLDERS_VARIABLE)))


def find_design(kind: str) -> type[Design]:
    """Return the design of a kind; raise `ParameterError`, listing the kinds, if there is none."""
    known = designs()
    if kind not in known:
        raise ParameterError.must(
            "design",
            f"be one of {', '.join(known)}, or of a file that {FOLDERS_VARIABLE} names",
            kind,
            choices=known,
        )
    return known[kind]


def margin_scales() -> dict[str, MarginScale]:
    """Return the scales of all designs' margins by name."""
    return {name: scale for design in designs().values() for name, scale in design.margins.items()}


def margin_text(name: str, value: float) -> str:
    """Return a margin as text with its unit."""
    scales = margin_scales()
    unit = scales[name].unit if name in scales else ""
    return f"{name} ±{value:g}{' ' + unit if unit else ''}"


def power_tables() -> dict[str, type[Design]]:
    """Return the designs by the names of their power tables."""
    return {name: design for design in designs().values() for name in design.power}


@lru_cache(maxsize=8)
def _designs(folders: tuple[Path, ...]) -> Mapping[str, type[Design]]:
    by_kind: dict[str, type[Design]] = {}
    for design in _classes(folders):
        kind = kind_of(design)
        if by_kind.setdefault(kind, design) is not design:
            raise ParameterError(
                f"two designs are called {kind!r}: {by_kind[kind].__module__}, {design.__module__}"
            )
    for label, names in (
        ("margins", [name for design in by_kind.values() for name in design.margins]),
        ("power tables", [name for design in by_kind.values() for name in design.power]),
    ):
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ParameterError(f"{label} of designs must differ in name, got {twice[0]!r} twice")
    return by_kind


def kind_of(design: type[Design]) -> str:
    """Return the kind of a design class, "" of a base class."""
    kind = design.model_fields["kind"].default
    return kind if isinstance(kind, str) else ""


def _classes(folders: tuple[Path, ...]) -> Iterator[type[Design]]:
    for module in iter_modules([str(Path(__file__).parent)]):
        yield from _module_designs(import_module(f"{PACKAGE}.{module.name}"))
    files = [path for folder in folders for path in module_files(folder, "study design")]
    places: list[str | Path] = [*entry_point_modules(ENTRY_POINTS), *files]
    for source in places:
        if not (held := list(_module_designs(import_plugin(source)))):
            raise ParameterError(f"{source}: must hold a study design, got none")
        yield from held


def _module_designs(module: ModuleType) -> Iterator[type[Design]]:
    """Yield the designs that a module defines, without those that it imports from elsewhere."""
    for value in vars(module).values():
        if not (isinstance(value, type) and issubclass(value, Design)) or isabstract(value):
            continue
        if kind_of(value) and f"{value.__module__}.".startswith(f"{module.__name__}."):
            yield value
