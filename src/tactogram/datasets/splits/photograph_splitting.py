"""Splitting of photographs: whole ones held out if a material has several, otherwise disjoint regions; their crops.

The photographs follow the recordings' split. A material whose recordings are all in one part (a split by material) has
all its photographs there: its surface is then unseen. A material with recordings in several parts has photographs in
each of them: whole ones if there are enough, otherwise disjoint rectangles of the same one. A photograph that only
recordings of one part name as their own goes with them.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np

from tactogram.datasets.splits.split import Region, Split
from tactogram.datasets.store.store import Store
from tactogram.errors import ParameterError
from tactogram.signal import Image

GAP = 16
"""Pixels between two regions of one photograph: the side of a JPEG block of colour."""
ORDER = ("train", "test", "validation")
"""Parts by their need of photographs."""
SMALLEST = 32
"""Pixels on each side of a region, so that it shows a texture."""


def split_photographs(
    store: Store,
    split: Split,
    *,
    seed: int,
    test: float = 0.1,
    validation: float = 0.1,
    gap: int = GAP,
    smallest: int = SMALLEST,
) -> Split:
    """Return ``split`` with the photographs, or regions of them, that each of its parts may use.

    Raises `ParameterError` if a share is invalid, or a photograph is too small to be cut for its parts.

    Parameters
    ----------
    split : Split
        Of recordings of ``store``.
    test, validation : float, 0 to 1
        Shares of each material's photographs if it has one for each of its parts; at least one for each. The paper of
        the visual-tactile GAN has 80/10/10 (Sec. 4.1).
    gap : int, pixels
        Distance between two regions of one photograph.
    smallest : int, pixels
        Smallest side of a region: crops must fit.

    Returns
    -------
    Split
        ``by_region`` names the materials whose parts share a photograph, ``photograph_note`` describes the split in a
        sentence. Materials without photographs get none; `require_photographs` refuses them.
    """
    if not (test >= 0 and validation >= 0 and test + validation < 1):
        raise ParameterError(f"test + validation must be below 1 and each >= 0, got {test} + {validation}")
    if gap < 0 or smallest < 1:
        raise ParameterError.must("gap", f"be >= 0 and smallest >= 1 pixels, got {gap} and {smallest}")
    materials, shared = _uses(store, split)
    dealt: dict[str, list[Region]] = {part: [] for part in split.parts}
    by_region: set[str] = set()
    whole: list[str] = []
    single_part: list[str] = []

    def cut(key: str, of: Sequence[str], parts: Sequence[str], random: np.random.Generator) -> None:
        try:
            size = store.photograph_size(key)
            regions = cut_photograph(key, size, parts, gap=gap, smallest=smallest, random=random)
        except ParameterError as error:
            raise ParameterError(f"photograph of {', '.join(of)}: {error}") from None
        for part, region in regions.items():
            dealt[part].append(region)
        by_region.update(of)

    for material, photographs in materials.items():
        random = np.random.default_rng([seed, zlib.crc32(material.encode())])
        by_part, remaining = photographs.deal({"test": test, "validation": validation}, random)
        for part, keys in by_part.items():
            dealt[part] += [Region(key) for key in keys]
        for key in remaining:
            cut(key, [material], photographs.parts, random)
        if not remaining:
            (single_part if len(photographs.parts) == 1 else whole).append(material)
    for key, (of, parts) in shared.items():
        if len(parts) == 1:
            dealt[parts[0]].append(Region(key))
        else:
            cut(key, of, parts, np.random.default_rng([seed, zlib.crc32(key.encode())]))
    return replace(
        split,
        photographs={part: tuple(sorted(regions, key=lambda r: r.key)) for part, regions in dealt.items()},
        photograph_gap=gap,
        by_region=tuple(sorted(by_region)),
        photograph_note=_note(sorted(by_region), whole, single_part, gap),
    )


def whole_photographs(store: Store) -> tuple[Region, ...]:
    """Return every photograph that shows a material: for data that no training used."""
    keys = {key for held in store.photographs_by_material.values() for key in held}
    return tuple(Region(key) for key in sorted(keys))


def cut_photograph(
    key: str,
    size: tuple[int, int],
    parts: Sequence[str],
    *,
    gap: int,
    smallest: int,
    random: np.random.Generator,
) -> dict[str, Region]:
    """Return a rectangle of one photograph for each of ``parts``, ``gap`` pixels apart.

    The first part gets one half across the longer side; the others share the other half in the same way. The half is
    drawn, so that light from one side in every photograph does not distinguish the parts. ``size`` is (rows, columns);
    a rectangle with a side below ``smallest`` is a `ParameterError`.
    """
    regions = {}
    top, left, bottom, right = 0, 0, *size
    for number, part in enumerate(parts):
        if number < len(parts) - 1:
            first, second = _halves((top, left, bottom, right), gap)
            if random.integers(2):
                first, second = second, first
            (top, left, bottom, right), own = second, first
        else:
            own = (top, left, bottom, right)
        if min(own[2] - own[0], own[3] - own[1]) < smallest:
            raise ParameterError(
                f"{size[0]} x {size[1]} pixels are too few to be cut into {len(parts)} parts of at least {smallest} "
                f"pixels a side, {gap} apart; give further photographs, a larger one, or split by material"
            )
        regions[part] = Region(key, *own)
    return regions


@dataclass(frozen=True)
class _MaterialPhotographs:
    """Photographs of one material, and the parts of its recordings."""

    parts: tuple[str, ...]
    """Parts with recordings of it, in `ORDER`."""
    tied: Mapping[str, str]
    """Part by key of photographs that only recordings of that part name as their own."""
    free: tuple[str, ...]
    """Other photographs of the material, sorted."""

    def deal(
        self, shares: Mapping[str, float], random: np.random.Generator
    ) -> tuple[dict[str, list[str]], tuple[str, ...]]:
        """Return whole photographs by part, and those to be cut because they are fewer than the parts."""
        dealt: dict[str, list[str]] = {part: [] for part in self.parts}
        for key, part in self.tied.items():
            dealt[part].append(key)
        if len(self.free) < sum(not keys for keys in dealt.values()):
            return dealt, self.free
        names = random.permutation(self.free).tolist()
        total = len(self.free) + len(self.tied)
        first, *others = self.parts
        for done, part in enumerate(others, 1):
            # One is reserved for each later part, and for the first, if it has none yet.
            reserved = sum(not dealt[other] for other in (first, *others[done:]))
            missing = max(round(shares[part] * total), 1) - len(dealt[part])
            count = max(min(missing, len(names) - reserved), 0)
            dealt[part] += names[:count]
            names = names[count:]
        dealt[first] += names
        return dealt, ()


def _uses(
    store: Store, split: Split
) -> tuple[dict[str, _MaterialPhotographs], dict[str, tuple[tuple[str, ...], tuple[str, ...]]]]:
    """Return the photographs of each material of ``split`` that has any, and those that several materials share.

    The latter are the materials and the parts of their recordings, by key.
    """
    parts_of: dict[str, set[str]] = {}
    owners: dict[str, set[str]] = {}
    for part, segments in split.parts.items():
        for segment in segments:
            material, key = store.info(segment.id).material, store.image_id(segment.id)
            if material is not None:
                parts_of.setdefault(material, set()).add(part)
            if key is not None:
                owners.setdefault(key, set()).add(part)
    materials_of: dict[str, list[str]] = {}
    for material in sorted(parts_of):
        for key in store.photographs_of(material):
            materials_of.setdefault(key, []).append(material)
    general = {key for held in store.facts.photographs.values() for key in held}
    shared = {
        key: (tuple(of), _ordered({part for material in of for part in parts_of[material]}))
        for key, of in sorted(materials_of.items())
        if len(of) > 1
    }
    uses = {}
    for material in sorted(parts_of):
        keys = [key for key in store.photographs_of(material) if key not in shared]
        tied = {
            key: next(iter(owners[key]))
            for key in keys
            if key not in general and len(owners.get(key, ())) == 1
        }
        free = tuple(key for key in keys if key in general or len(owners.get(key, ())) > 1)
        if tied or free:
            uses[material] = _MaterialPhotographs(_ordered(parts_of[material]), tied, free)
    return uses, shared


def _ordered(parts: set[str]) -> tuple[str, ...]:
    return tuple(part for part in ORDER if part in parts)


def _halves(box: tuple[int, int, int, int], gap: int) -> tuple[tuple[int, int, int, int], ...]:
    """Return the two halves of (top, left, bottom, right) across its longer side, ``gap`` apart."""
    top, left, bottom, right = box
    if bottom - top >= right - left:
        middle = (top + bottom - gap) // 2
        return (top, left, middle, right), (middle + gap, left, bottom, right)
    middle = (left + right - gap) // 2
    return (top, left, bottom, middle), (top, middle + gap, bottom, right)


def _note(by_region: Sequence[str], whole: Sequence[str], single_part: Sequence[str], gap: int) -> str:
    sentences = []
    if single_part:
        sentences.append(
            f"{len(single_part)} materials stand in one part each, with all their photographs: those tested are "
            "surfaces never seen"
        )
    if whole:
        sentences.append(
            f"of {len(whole)} materials photographs were held out whole: surfaces seen, photographs not"
        )
    if by_region:
        sentences.append(
            f"of {len(by_region)} materials there are too few photographs to hold one out: disjoint regions of the "
            f"same one, {gap} pixels apart, were trained on and tested ({', '.join(by_region)})"
        )
    return "; ".join(sentences) or "no photographs"


class PhotographRegions(Sequence[Image]):
    """Regions of photographs in a store, each decoded and cut on demand."""

    def __init__(self, store: Store, regions: Iterable[Region]) -> None:
        self.store, self.regions = store, tuple(regions)

    def __len__(self) -> int:
        return len(self.regions)

    @overload
    def __getitem__(self, index: int) -> Image: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Image]: ...
    def __getitem__(self, index: int | slice) -> Image | Sequence[Image]:
        if isinstance(index, slice):
            return PhotographRegions(self.store, self.regions[index])
        return cut_out(self.store, self.regions[index])


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
