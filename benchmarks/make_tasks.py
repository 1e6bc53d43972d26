"""Splits of the benchmark's tasks, drawn once; the tasks state their hashes.

``python -m benchmarks.make_tasks STORES`` writes them again from the stores in a folder, and prints each hash. A split
that changes makes another task.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tactogram.datasets import (
    RecordingInfo,
    Region,
    Segment,
    Split,
    Store,
    item_of,
    open_store,
    split_last,
    split_photographs,
)
from tactogram_benchmark.task import TASKS

SPLITS = TASKS / "splits"


def main(folder: Path) -> None:
    stores = [open_store(file.parent) for file in sorted(folder.glob("*/dataset.json"))]
    by_name = {store.facts.source if store.simulated else store.name: store for store in stores}
    for name, (wanted, make) in SPLIT_OF.items():
        found = [store for key, store in by_name.items() if key.startswith(wanted)]
        if not found:
            print(f"{name}: no store of {wanted}")
            continue
        path = SPLITS / f"{name}.json"
        make(found[0]).save(path)
        print(f"{name}: {hashlib.sha256(path.read_bytes()).hexdigest()}  store {found[0].sha256}")


def last(number: int) -> Callable[[Store], Split]:
    """Split off the last recordings of each material; the one before is for validation."""
    return lambda store: split_last(store.index, number, validation=1)


def strangers(store: Store, count: int) -> set[str]:
    """Draw materials that are left out of training."""
    names = sorted({str(info.material) for info in store.index})
    return set(np.random.default_rng(0).permutation(names)[:count].tolist())


def unknown_last(unknown: int, number: int) -> Callable[[Store], Split]:
    """Leave some materials out of training; of the others as `last`."""

    def make(store: Store) -> Split:
        strange = strangers(store, unknown)
        known = split_last([i for i in store.index if i.material not in strange], number, validation=1)
        left_out = tuple(Segment(info.id) for info in store.index if info.material in strange)
        return replace(known, test=(*known.test, *left_out))

    return make


def unknown_surfaces(unknown: int) -> Callable[[Store], Split]:
    """Leave some surfaces out of training; of the others the last stroke at each speed by each contactor is tested.

    The one before validates.
    """

    def make(store: Store) -> Split:
        strange = strangers(store, unknown)
        strokes: dict[tuple[str, float | None, str | None], list[Segment]] = {}
        for info in store.index:
            key = (str(info.material), info.speed_mm_s, info.contactor)
            strokes.setdefault(key, []).append(Segment(info.id))
        known = [held for (name, *_), held in strokes.items() if name not in strange]
        left_out = [held for (name, *_), held in strokes.items() if name in strange]
        return Split(
            tuple(segment for held in known for segment in held[:-2]),
            tuple(held[-2] for held in known),
            (*(held[-1] for held in known), *(segment for held in left_out for segment in held)),
            by="recording",
        )

    return make


def held_out(
    test: Callable[[RecordingInfo], bool],
    group: Callable[[RecordingInfo], str],
    contactor: str | None = None,
) -> Callable[[Store], Split]:
    """Test on the recordings (of one contactor) that fulfil a condition; every eighth of the others validates."""

    def make(store: Store) -> Split:
        index = _by_contactor(store, contactor)
        train = [info for info in index if not test(info)]
        kept = tuple(Segment(info.id) for info in index if test(info))
        groups = {info.id: group(info) for info in index if test(info)}
        return Split(
            tuple(Segment(info.id) for number, info in enumerate(train) if number % 8),
            tuple(Segment(info.id) for info in train[::8]),
            kept,
            by="condition",
            groups=groups,
        )

    return make


def _by_contactor(store: Store, contactor: str | None) -> list[RecordingInfo]:
    return [info for info in store.index if contactor in (None, info.contactor)]


def one_stroke(given: float, asked: float, contactor: str) -> Callable[[Store], Split]:
    """Train on a contactor's first stroke of each surface at one speed, and test on all of its strokes at another."""

    def make(store: Store) -> Split:
        first: dict[str, str] = {}
        index = _by_contactor(store, contactor)
        for info in index:
            if info.speed_mm_s == given:
                first.setdefault(str(info.material), info.id)
        test = tuple(Segment(info.id) for info in index if info.speed_mm_s == asked)
        return Split(tuple(map(Segment, first.values())), (), test, by="recording")

    return make


def photographs(split: Callable[[Store], Split]) -> Callable[[Store], Split]:
    """Split photographs, too."""
    return lambda store: split_photographs(store, split(store), seed=0)


def materials_left_out(test: int, validation: int) -> Callable[[Store], Split]:
    """Leave materials out of training, for testing and for validation."""

    def make(store: Store) -> Split:
        names = (
            np.random.default_rng(1)
            .permutation(sorted({str(info.material) for info in store.index}))
            .tolist()
        )
        part = dict.fromkeys(names, "train") | dict.fromkeys(names[:test], "test")
        part |= dict.fromkeys(names[test : test + validation], "validation")
        held: dict[str, list[Segment]] = {"train": [], "validation": [], "test": []}
        for info in store.index:
            held[part[str(info.material)]].append(Segment(info.id))
        groups = {info.id: str(info.material) for info in store.index}
        return Split(*(tuple(held[p]) for p in ("train", "validation", "test")), by="material", groups=groups)

    return make


def items(shares: tuple[float, float]) -> Callable[[Store], Split]:
    """Deal rated items to training, validation and test."""

    def make(store: Store) -> Split:
        rated = set(store.ratings.items) if store.ratings else set()
        if len(store):
            long = [i for i in store.index if item_of(i) in rated and _seconds(store, i) >= 0.16]
            # Rated signals, which are of no material, or surfaces; beside signals the surfaces are not asked.
            long = [info for info in long if info.material is None] or long
            names = sorted({str(item_of(info)) for info in long})
        else:
            names = sorted(set(store.photographs_by_material) & rated)
        shuffled = np.random.default_rng(0).permutation(names).tolist()
        ends = [round(share * len(names)) for share in np.cumsum(shares)]
        part = dict.fromkeys(shuffled[ends[1] :], "test")
        part |= dict.fromkeys(shuffled[: ends[0]], "train") | dict.fromkeys(
            shuffled[ends[0] : ends[1]], "validation"
        )
        held: dict[str, list[str]] = {"train": [], "validation": [], "test": []}
        if not len(store):
            for name in names:
                held[part[name]] += store.photographs_by_material[name]
            regions = {p: tuple(Region(key) for key in keys) for p, keys in held.items()}
            return Split((), (), (), by="material", photographs=regions)
        for info in long:
            held[part[str(item_of(info))]].append(info.id)
        groups = {info.id: str(item_of(info)) for info in long}
        return Split(*(tuple(map(Segment, held[p])) for p in held), by="material", groups=groups)

    return make


def _seconds(store: Store, info: RecordingInfo) -> float:
    stream = store.streams_of(info.id)[0]
    return store.length(info.id, stream) / store.rate(info.id, stream)


def pieces(test: Sequence[str]) -> Callable[[Store], Split]:
    """Test on takes of these numbers, validate on the one before, with the own photograph of each."""

    def make(store: Store) -> Split:
        held: dict[str, list[Segment]] = {"train": [], "validation": [], "test": []}
        for info in store.index:
            take = info.labels["recording"]
            held["test" if take in test else "train"].append(Segment(info.id))
        split = Split(*(tuple(held[p]) for p in held), by="recording")
        return split_photographs(store, split, seed=0)

    return make


def blocks(store: Store) -> Split:
    """Train on the first part of each recording, over displacement, and test on the last; so for the photographs."""
    train, test = [], []
    for info in store.index:
        length = store.length(info.id, "friction") / store.rate(info.id, "friction")
        train.append(Segment(info.id, 0.0, round(0.6 * length, 1)))
        test.append(Segment(info.id, round(0.65 * length, 1), round(length, 1)))
    split = Split(tuple(train), (), tuple(test), by="block", gap_s=1.0)
    return split_photographs(store, split, seed=0)


def at_speed(speed: float, contactor: str | None = None) -> Callable[[Store], Split]:
    """Test on the recordings (of one contactor) at one speed."""
    return held_out(lambda info: info.speed_mm_s == speed, lambda info: f"{info.speed_mm_s:g}", contactor)


FAMILIES = (
    "sandpaper", "paper", "leather", "floortile", "tile", "brick", "canvas", "carpet", "silk", "velcro", "vinyl",
    "acrylic", "foam", "mesh", "metal", "aluminum", "carbon fiber", "wood", "card", "whiteboard", "folio", "cloth",
)  # fmt: skip
"""Surfaces of HaTT whose name has one of these, the first in this order, are a family; others are their own."""


def family(material: str) -> str:
    """Return the family of a surface of HaTT."""
    return next((word for word in FAMILIES if word in material.lower()), material)


def parts_of_families(store: Store, test: int, validation: int) -> dict[str, str]:
    """Deal families of surfaces to the parts until there are as many surfaces in each; return the part by surface."""
    held: dict[str, list[str]] = {}
    for name in sorted({str(info.material) for info in store.index}):
        held.setdefault(family(name), []).append(name)
    part: dict[str, str] = {}
    counts = {"test": 0, "validation": 0}
    for name in np.random.default_rng(0).permutation(sorted(held)).tolist():
        where = (
            "test"
            if counts["test"] < test
            else "validation"
            if counts["validation"] < validation
            else "train"
        )
        counts[where] = counts.get(where, 0) + len(held[name])
        part |= dict.fromkeys(held[name], where)
    return part


def families(test: int, validation: int, asked: tuple[float, float]) -> Callable[[Store], Split]:
    """Leave families of surfaces out; test both halves of their recordings at one speed and force.

    The recordings are synthesised, so that halves are as independent as takes: one is compared, one is the floor.
    """

    def make(store: Store) -> Split:
        part = parts_of_families(store, test, validation)
        held: dict[str, list[Segment]] = {"train": [], "validation": [], "test": []}
        for info in store.index:
            place = part[str(info.material)]
            if place != "test":
                held[place].append(Segment(info.id))
            elif (info.speed_mm_s, info.force_n) == asked:
                held["test"] += _halves(store, info)
        groups = {info.id: family(str(info.material)) for info in store.index}
        return Split(*(tuple(held[p]) for p in held), by="material", groups=groups)

    return photographs(make)


def families_one_stroke(
    test: int, validation: int, given: tuple[float, float], asked: tuple[float, float]
) -> Callable[[Store], Split]:
    """Of the families left out, train on one recording of each surface, and test at another speed and force."""

    def make(store: Store) -> Split:
        part = parts_of_families(store, test, validation)
        held: dict[str, list[Segment]] = {"train": [], "validation": [], "test": []}
        reached = {info.material for info in store.index if (info.speed_mm_s, info.force_n) == asked}
        for info in store.index:
            place, condition = part[str(info.material)], (info.speed_mm_s, info.force_n)
            if place != "test":
                held[place].append(Segment(info.id))
            elif condition == given and info.material in reached:
                held["train"].append(Segment(info.id))
            elif condition == asked:
                held["test"] += _halves(store, info)
        return Split(*(tuple(held[p]) for p in held), by="recording")

    return make


def _halves(store: Store, info: RecordingInfo) -> tuple[Segment, Segment]:
    end = round(_seconds(store, info), 3)
    return Segment(info.id, 0.0, end / 2), Segment(info.id, end / 2, end)


SIMULATED = "tactogram data simulate "
SPLIT_OF = {
    "lmt108": ("lmt108", last(2)),
    "lmt108-unknown": ("lmt108", unknown_last(8, 2)),
    "biotac-photo": ("biotac_slide", photographs(last(8))),
    "biotac-new": ("biotac_slide", photographs(materials_left_out(4, 1))),
    "cdplab": ("cdplab", blocks),
    "hatt-families": ("hatt", families(40, 10, (100.0, 1.0))),
    "hatt-one-stroke": ("hatt", families_one_stroke(40, 10, (50.0, 0.5), (150.0, 1.0))),
    "vibviz": ("vibviz", items((0.4, 0.35))),
    "strokes": (SIMULATED + "stroking9 --seed 17", last(4)),
    "contactor": (
        SIMULATED + "stroking30",
        held_out(lambda i: i.contactor == "pen", lambda i: str(i.contactor)),
    ),
    "speed-30": (SIMULATED + "stroking30", at_speed(200)),
    "speeds": (SIMULATED + "surfaces --seed 1 ", at_speed(120, "stylus")),
    "surfaces-unknown": (SIMULATED + "surfaces --seed 1 ", unknown_surfaces(9)),
    "one-stroke": (SIMULATED + "surfaces --seed 1 ", one_stroke(60, 240, "stylus")),
    "rated": (SIMULATED + "surfaces --seed 2 ", items((0.5, 0.25))),
    "display": (SIMULATED + "ultrasonic", items((0.4, 0.35))),
    "fabrics": (SIMULATED + "fabrics", pieces(("4",))),
    "images": (SIMULATED + "tactile_images", items((0.5, 0.3))),
}

if __name__ == "__main__":
    main(Path(sys.argv[1]))
