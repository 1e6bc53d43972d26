"""Child seeds: a random stream for every purpose from one seed, without global random state."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from tactogram.model import Condition

if TYPE_CHECKING:
    import torch


def child_seed(seed: int, *purpose: str | int) -> int:
    """Return a seed for one purpose, e.g. ``child_seed(0, "batches", "train", 17)``; 63 bits."""
    numbers = [zlib.crc32(p.encode()) if isinstance(p, str) else p for p in purpose]
    return int(np.random.SeedSequence([seed, *numbers]).generate_state(1, np.uint64)[0] >> 1)


def child_rng(seed: int, *purpose: str | int) -> np.random.Generator:
    """Return numpy's generator for one purpose."""
    return np.random.default_rng(child_seed(seed, *purpose))


def child_generator(seed: int, *purpose: str | int) -> torch.Generator:
    """Return torch's generator for one purpose."""
    import torch

    return torch.Generator().manual_seed(child_seed(seed, *purpose))


def surface_seed(seed: int, condition: Condition) -> int:
    """Return the seed of the surface that a condition describes: with one noise, surfaces would have one rhythm.

    It follows from the names of materials, the scores of words, pixels and samples, not from speed, force or motion: a
    surface keeps its noise at another speed. So does a mix at other weights (> 0): the steps of a ladder differ by
    their weights alone, but for its ends, which are materials.
    """
    material, words = condition.get("material") or {}, condition.get("words") or {}
    named = [material] if isinstance(material, str) else [name for name, w in dict(material).items() if w]
    scores = [f"{word} {words[word]:g}" for word in sorted(words)]
    image, vibration = condition.get("image"), condition.get("vibration")
    arrays = image is not None and image.pixels, vibration is not None and vibration.samples
    measured = (zlib.crc32(np.ascontiguousarray(array).tobytes()) for array in arrays)
    return child_seed(seed, "surface", *sorted(named), "words", *scores, *measured)


@contextmanager
def torch_seeded(seed: int, *purpose: str | int) -> Iterator[None]:
    """Seed torch's global generator (dropout, initial weights), and restore its state afterwards."""
    import torch

    devices = range(torch.cuda.device_count()) if torch.cuda.is_available() else ()
    with torch.random.fork_rng(devices=devices):
        torch.manual_seed(child_seed(seed, *purpose))
        yield
