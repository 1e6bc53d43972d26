"""Materials of the simulated sets, a row each of ``surfaces.csv``: imagined formulas, not measurements.

Empty cells have the default. ``textures`` are added up; each is a class of `tactogram.datasets.simulate.surfaces` and
its numbers. ``made`` and ``fine_um`` are of `tactogram.datasets.simulate.metal_plates.Plate`. Everyday surfaces have a
``kind`` and, written by ``python -m benchmarks.set_everyday``, the share of their heights that is ``felt``, and the rms
and beta of the ground besides; ``also`` are other names and typical objects.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from importlib.resources import files
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

TEXTURES = {each.__name__: each for each in (Grating, Weave, Particles, Roughness, Cells)}


@cache
def rows(set_name: str) -> tuple[Mapping[str, str], ...]:
    """Return the rows of a set, without empty cells."""
    text = files("tactogram.datasets.simulate").joinpath("surfaces.csv").read_text(encoding="utf-8")
    filled = ({name: cell for name, cell in row.items() if cell} for row in csv.DictReader(text.splitlines()))
    return tuple(row for row in filled if row["set"] == set_name)


def surfaces_of(set_name: str) -> tuple[Surface, ...]:
    """Return the materials of a set, as drawn."""
    return tuple(_surface(row) for row in rows(set_name))


def numbers(cell: str) -> list[Any]:
    """Return the numbers in a cell, whole ones as int."""
    return [json.loads(text) for text in cell.split()]


def _surface(row: Mapping[str, str]) -> Surface:
    own = {f.name for kind in (Surface, Appearance) for f in fields(kind)} - {
        "name",
        "textures",
        "felt",
        "look",
    }
    values: dict[str, Any] = {
        name: tuple(numbers(cell)) if name in ("colour", "hollow") else numbers(cell)[0]
        for name, cell in row.items()
        if name in own
    }
    look = {f.name: values.pop(f.name) for f in fields(Appearance) if f.name in values}
    textures = tuple(_texture(*text.split(maxsplit=1)) for text in row["textures"].split(" + "))
    return Surface(row["name"], textures, **values, look=Appearance(**look))


def _texture(kind: str, cell: str) -> Texture:
    texture: Texture = TEXTURES[kind](*numbers(cell))
    return texture


STROKING_30, STROKING_9 = surfaces_of("stroking30"), surfaces_of("stroking9")
"""Named after the materials of Saga et al."""
