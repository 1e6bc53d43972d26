"""Display families by name, found by looking into the folder ``rendering.families`` and further ones."""

from __future__ import annotations

from tactogram.errors import ParameterError
from tactogram.plugins import PluginGroup
from tactogram.rendering.displays.family import DisplayFamily

FAMILIES = PluginGroup(
    "display family",
    "tactogram.rendering.families",
    "tactogram.display_families",
    "TACTOGRAM_DISPLAY_FAMILIES",
)
"""Modules with a ``FAMILY``, a `DisplayFamily`."""


def display_family(name: str) -> DisplayFamily:
    """Return a family by name.

    Raises
    ------
    ParameterError
        If there is none of that name, or its module declares none.
    """
    module = FAMILIES.module(name)
    family = getattr(module, "FAMILY", None)
    if not isinstance(family, DisplayFamily) or family.name != name:
        raise ParameterError(f"{module.__file__}: must define FAMILY, a DisplayFamily called {name!r}")
    return family
