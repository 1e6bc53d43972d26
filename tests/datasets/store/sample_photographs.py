"""Stores of photographs."""

import numpy as np

from tactogram.datasets import Examples, Recording, create_store, split_fractions
from tactogram.recipe import Preparation
from tactogram.signal import Image, Signal


def picture(seed, rows=96, columns=80):
    pixels = np.random.default_rng(seed).integers(0, 256, (rows, columns, 3), dtype=np.uint8)
    return Image(pixels, 0.1)


def recording(material, number, image=None):
    samples = np.random.default_rng([number, *material.encode()]).standard_normal(50)
    return Recording(
        streams={"acceleration": Signal(samples, 100.0, "m/s^2")}, material=material, image=image
    )


def store_of(folder, photographs, *, takes=10, images=None):
    """A store with some photographs of each material, and ``takes`` recordings of each."""
    recordings = [recording(m, i, (images or {}).get(m)) for m in photographs for i in range(takes)]
    shown = [(m, picture([n, *m.encode()])) for m, count in photographs.items() for n in range(count)]
    return create_store(folder / "s", recordings, name="test", licence="CC0-1.0", photographs=shown)


def by_recording(store, **changes):
    return split_fractions(store.index, seed=1, **({"test": 0.2, "validation": 0.2} | changes))


def examples(store, split, part):
    return Examples(store, split.parts[part], Preparation(), photographs=split.photographs[part])
