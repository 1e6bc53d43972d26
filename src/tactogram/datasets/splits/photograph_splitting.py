"""The photographs of a split: whole ones held out where a material has several, disjoint regions where it has not.

What the recordings' split asks, the photographs follow. A material whose recordings all stand in one part (a split by
material) has all its photographs there: the question is then what a surface feels like that was never seen. A
material with recordings in several parts has photographs in each of them: whole ones where there are enough, else
disjoint rectangles of the same one. A photograph that only recordings of one part name as their own goes with them.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactogram.datasets.splits.split import Region, Split
from tactogram.datasets.store.store import Store
from tactogram.errors import ParameterError

GAP = 16
"""Pixels left out between two regions of one photograph: the side of a JPEG block of colour."""
ORDER = ("train", "test", "validation")
"""Of the parts, the one that needs most photographs first."""
SMALLEST = 32
"""Pixels that each side of a region must have, so that there is a texture to be seen in it."""


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

    Parameters
    ----------
    store : Store
    split : Split
        Of recordings of ``store``.
    seed : int
    test, validation : float, 0 to 1
        Shares of each material's photographs where it has one for each of its parts; at least one for each. The
        paper of the visual-tactile GAN has 80/10/10 (Sec. 4.1).
    gap : int, pixels
        What is left out between two regions of one photograph.
    smallest : int, pixels
        Sides that a region has at least: what is cut from it must fit.

    Returns
    -------
    Split
        ``by_region`` names the materials whose parts share a photograph, ``photograph_note`` says it in a sentence.
        Materials without photographs have none; `require_photographs` refuses them.

    Raises
    ------
    ParameterError
        If a share is not one, or a photograph is too small to be cut for its parts.
    """
    if not (test >= 0 and validation >= 0 and test + validation < 1):
        raise ParameterError(f"test + validation must be below 1 and each >= 0, got {test} + {validation}")
    if gap < 0 or smallest < 1:
        raise ParameterError(f"gap must be >= 0 and smallest >= 1 pixels, got {gap} and {smallest}")
    materials, shared = _uses(store, split)
    dealt: dict[str, list[Region]] = {part: [] for part in split.parts}
    by_region: set[str] = set()
    whole: list[str] = []
    followed: list[str] = []

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
        given, left = photographs.deal({"test": test, "validation": validation}, random)
        for part, keys in given.items():
            dealt[part] += [Region(key) for key in keys]
        for key in left:
            cut(key, [material], photographs.parts, random)
        if not left:
            (followed if len(photographs.parts) == 1 else whole).append(material)
    for key, (of, parts) in shared.items():
        if len(parts) == 1:
            dealt[parts[0]].append(Region(key))
        else:
            cut(key, of, parts, np.random.default_rng([seed, zlib.crc32(key.encode())]))
    return replace(
        split,
        photographs={part: tuple(sorted(held, key=lambda r: r.key)) for part, held in dealt.items()},
        photograph_gap=gap,
        by_region=tuple(sorted(by_region)),
        photograph_note=_note(sorted(by_region), whole, followed, gap),
    )


def whole_photographs(store: Store, materials: Iterable[str] | None = None) -> tuple[Region, ...]:
    """Return every photograph of ``materials``, by default of all: for data that nothing was trained on."""
    wanted = store.photographs_by_material if materials is None else set(materials)
    keys = {key for name, held in store.photographs_by_material.items() if name in wanted for key in held}
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

    The first part has one half across the longer side; the others share the other half in the same way. Which half
    is drawn, so that the light that falls from one side in every photograph does not tell the parts apart.

    Parameters
    ----------
    key : str
    size : (rows, columns)
    parts : sequence of str
        The one that needs most first.
    gap, smallest : int, pixels
    random : Generator

    Raises
    ------
    ParameterError
        If a rectangle would have a side below ``smallest``.
    """
    regions = {}
    top, left, bottom, right = 0, 0, *size
    for place, part in enumerate(parts):
        if place < len(parts) - 1:
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
    """The photographs of one material, and where its recordings stand."""

    parts: tuple[str, ...]
    """Parts that have recordings of it, in `ORDER`."""
    tied: Mapping[str, str]
    """Part by key, of photographs that only recordings of that part name as their own."""
    free: tuple[str, ...]
    """Photographs of the material at large, sorted."""

    def deal(
        self, shares: Mapping[str, float], random: np.random.Generator
    ) -> tuple[dict[str, list[str]], tuple[str, ...]]:
        """Return whole photographs by part, and those left to be cut: too few to give each part one."""
        given: dict[str, list[str]] = {part: [] for part in self.parts}
        for key, part in self.tied.items():
            given[part].append(key)
        if len(self.free) < sum(not held for held in given.values()):
            return given, self.free
        names = random.permutation(self.free).tolist()
        total = len(self.free) + len(self.tied)
        first, *others = self.parts
        for done, part in enumerate(others, 1):
            # One is kept for each part still to come, and for the first, that has none yet.
            kept = sum(not given[other] for other in (first, *others[done:]))
            wanted = max(round(shares[part] * total), 1) - len(given[part])
            count = max(min(wanted, len(names) - kept), 0)
            given[part] += names[:count]
            names = names[count:]
        given[first] += names
        return given, ()


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


def _note(by_region: Sequence[str], whole: Sequence[str], followed: Sequence[str], gap: int) -> str:
    told = []
    if followed:
        told.append(
            f"{len(followed)} materials stand in one part each, with all their photographs: those tested are surfaces "
            "never seen"
        )
    if whole:
        told.append(
            f"of {len(whole)} materials photographs were held out whole: surfaces seen, photographs not"
        )
    if by_region:
        told.append(
            f"of {len(by_region)} materials there are too few photographs to hold one out: disjoint regions of the "
            f"same one, {gap} pixels apart, were trained on and tested ({', '.join(by_region)})"
        )
    return "; ".join(told) or "no photographs"
