"""Names of everyday materials, a row each of ``everyday.csv``: their kind, and other names and typical objects.

Simulated surfaces have these names, and so do the materials of the weights that come with the package.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from importlib.resources import files

_ROWS = [
    *csv.DictReader(files("tactogram.datasets").joinpath("everyday.csv").read_text("utf-8").splitlines())
]
KIND_OF: Mapping[str, str] = {row["name"]: row["kind"] for row in _ROWS}
SYNONYMS: Mapping[str, tuple[str, ...]] = {
    row["name"]: tuple(row["also"].split("; ")) for row in _ROWS if row["also"]
}
"""Other names and typical objects."""
MEASURED: Mapping[str, int] = {
    "fabric": 14,
    "carpet": 5,
    "paper": 16,
    "leather": 4,
    "foam": 3,
    "plastic": 8,
    "mineral": 6,
    "metal": 3,
    "other": 60,
}
"""Real materials of each kind in one half of the Penn Haptic Texture Toolkit (Culbertson et al. 2014).

Of ``other`` it is all: of wood the half has a single material.
"""


def known_from(name: str) -> str:
    """Return what the simulated surface of an everyday material was set from, in words."""
    kind = KIND_OF[name]
    of = "all kinds" if kind == "other" else f"the kind {kind}"
    return (
        f"level and slope of the spectrum from the mean of {MEASURED[kind]} real materials of {of} "
        "(Penn Haptic Texture Toolkit); dimensions of its structure are plausible, not measured"
    )
