"""Everyday surfaces by their usual names: invented height fields with plausible dimensions.

Their level and the slope of their spectrum are set to means of real materials of their kind (`KINDS`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from tactogram.datasets.simulate.materials import numbers, rows, surfaces_of
from tactogram.datasets.simulate.surfaces import Roughness, Surface


class Kind(NamedTuple):
    """Level and slope that the surfaces of a kind are set to, and the real materials that they are known from.

    Attributes
    ----------
    level_db : float
        Of a stylus at 120 mm/s and 1 N, 20 to 480 Hz, dB re 1 m/s^2.
    slope_db : float
        Of the spectrum's density, dB per octave.
    materials : int
        Real materials of that kind in one half of the Penn Haptic Texture Toolkit (Culbertson et al. 2014), whose mean,
        drawn towards that of all 60 by the weight of four more, this is.
    """

    level_db: float
    slope_db: float
    materials: int


KINDS: Mapping[str, Kind] = {
    "fabric": Kind(-2.2, -5.1, 14),
    "carpet": Kind(4.9, -6.5, 5),
    "paper": Kind(-1.6, -3.9, 16),
    "leather": Kind(-2.0, -5.7, 4),
    "foam": Kind(0.6, -4.9, 3),
    "plastic": Kind(0.1, -3.9, 8),
    "mineral": Kind(8.3, -2.2, 6),
    "metal": Kind(-0.1, -4.2, 3),
    "other": Kind(0.5, -4.5, 60),
}
"""The surfaces of ``other`` have the mean of all: of wood the half has a single material."""


def as_measured(surface: Surface, felt: float, rms_mm: float, beta: float) -> Surface:
    """Return a surface of which a share is felt, and of a ground besides: the spectra of real materials are smooth."""
    return replace(surface, felt=felt, ground=Roughness(rms_mm, beta, 0.05, 8.0))


ROWS = {row["name"]: row for row in rows("everyday")}
DRAWN = surfaces_of("everyday")
EVERYDAY = tuple(
    as_measured(
        surface,
        *numbers(" ".join(ROWS[surface.name][name] for name in ("felt", "ground_rms_mm", "ground_beta"))),
    )
    for surface in DRAWN
)
SYNONYMS = {name: tuple(row["also"].split("; ")) for name, row in ROWS.items() if "also" in row}
"""Other names and typical objects of the surfaces."""


def known_from(name: str) -> str:
    """Return what an everyday surface was set from, in words."""
    kind = ROWS[name]["kind"]
    of = "all kinds" if kind == "other" else f"the kind {kind}"
    return (
        f"level and slope of the spectrum from the mean of {KINDS[kind].materials} real materials of {of} "
        "(Penn Haptic Texture Toolkit); dimensions of its structure are plausible, not measured"
    )
