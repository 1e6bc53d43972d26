"""The nine textures of Saga et al., Sec. III-B, by their names in a data set."""

from __future__ import annotations

from tactogram.datasets import Store
from tactogram.errors import DataError

IN_RECORDINGS = {
    "artificial-grass": "ArtGrass01",
    "carpet": "Carpet01",
    "tile": "GreenTile",
    "cloth": "ArtLeather",
    "cork-sheet": "CorkSheet",
    "punched-plastic-sheet": "EnbiPunch",
    "luncheon-mat-01": "Luncheon01",
    "luncheon-mat-02": "Luncheon02",
    "luncheon-mat-03": "Luncheon03",
}
"""Names in the laboratory's recordings (`tactogram.datasets.importers.saga_strokes`) by those of the simulated set. The
recordings have no cloth; artificial leather, which the paper does not name, is assumed to be it."""


def materials_of(store: Store) -> dict[str, str]:
    """Return the store's material of each of the nine textures.

    Raises `DataError` if one is missing.
    """
    known = {info.material for info in store.index}
    found = {
        name: next((m for m in (name, other) if m in known), "") for name, other in IN_RECORDINGS.items()
    }
    if missing := [name for name, material in found.items() if not material]:
        raise DataError(
            f"{store.path}: must have the nine textures of Saga et al., found none called "
            + ", ".join(f"{name} or {IN_RECORDINGS[name]}" for name in missing)
        )
    return found
