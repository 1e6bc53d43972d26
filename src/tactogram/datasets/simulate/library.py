"""Named surfaces of the simulator, in ``library.toml``: invented height fields, not measurements."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tactogram.datasets.simulate.surfaces import (
    Appearance,
    Cells,
    Grating,
    Particles,
    Roughness,
    Surface,
    Texture,
    Weave,
)
from tactogram.text_files import read_toml

TEXTURES: Mapping[str, type[Texture]] = {
    "cells": Cells, "grating": Grating, "particles": Particles, "roughness": Roughness, "weave": Weave
}  # fmt: skip


def _surface(values: Mapping[str, Any]) -> Surface:
    textures = tuple(
        TEXTURES[texture["kind"]](**{name: value for name, value in texture.items() if name != "kind"})
        for texture in values["textures"]
    )
    look: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value for name, value in values["look"].items()
    }
    facts = {name: value for name, value in values.items() if name != "also"}
    return Surface(**{**facts, "textures": textures, "look": Appearance(**look)})


_LIBRARY = read_toml(Path(__file__).with_name("library.toml"))
EVERYDAY, STROKING_30, STROKING_9, FABRICS = (
    tuple(map(_surface, _LIBRARY[name])) for name in ("everyday", "stroking30", "stroking9", "fabrics")
)
"""Surfaces by their usual names, and named after those of Saga et al., Sec. II and Sec. III-B; fabrics."""
SYNONYMS: Mapping[str, tuple[str, ...]] = {
    values["name"]: tuple(values["also"]) for values in _LIBRARY["everyday"] if "also" in values
}
"""Other names and typical objects of the everyday surfaces."""
