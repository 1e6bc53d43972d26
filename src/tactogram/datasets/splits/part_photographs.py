"""Photographs that one part of a split may use, by material; decoded and cut on demand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import overload

from tactogram.datasets.splits.split import Region
from tactogram.datasets.store.store import Store
from tactogram.signal import Image


class PhotographRegions(Sequence[Image]):
    """Regions of photographs in a store, each decoded and cut on demand."""

    def __init__(self, store: Store, regions: Iterable[Region]) -> None:
        self.store, self.regions = store, tuple(regions)

    def __len__(self) -> int:
        return len(self.regions)

    @overload
    def __getitem__(self, place: int) -> Image: ...
    @overload
    def __getitem__(self, place: slice) -> Sequence[Image]: ...
    def __getitem__(self, place: int | slice) -> Image | Sequence[Image]:
        if isinstance(place, slice):
            return PhotographRegions(self.store, self.regions[place])
        return cut_out(self.store, self.regions[place])


def cut_out(store: Store, region: Region) -> Image:
    """Return a region of a photograph as an image."""
    whole = store.photograph(region.key)
    return whole if region.whole else whole.cut(region.top, region.left, region.bottom, region.right)


def by_material(store: Store, regions: Iterable[Region]) -> dict[str, tuple[Region, ...]]:
    """Return ``regions`` by the material they show."""
    by_key: dict[str, list[Region]] = {}
    for region in regions:
        by_key.setdefault(region.key, []).append(region)
    return {
        material: tuple(region for key in keys for region in by_key.get(key, ()))
        for material, keys in store.photographs_by_material.items()
    }


def materials_without_photographs(store: Store) -> tuple[str, ...]:
    """Return the materials of ``store`` that have recordings and no photograph, sorted."""
    named = {info.material for info in store.index if info.material is not None}
    return tuple(sorted(named - store.photographs_by_material.keys()))


def materials_without_recordings(store: Store) -> tuple[str, ...]:
    """Return the materials of ``store`` that have photographs and no recording, sorted."""
    named = {info.material for info in store.index}
    return tuple(sorted(store.photographs_by_material.keys() - named))
