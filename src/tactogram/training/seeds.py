"""Child seeds: a random stream for every purpose from one seed, without global random state."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
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
    return torch.Generator().manual_seed(child_seed(seed, *purpose))


@contextmanager
def torch_seeded(seed: int, *purpose: str | int) -> Iterator[None]:
    """Seed torch's global generator (dropout, initial weights), and restore its state afterwards."""
    devices = range(torch.cuda.device_count()) if torch.cuda.is_available() else ()
    with torch.random.fork_rng(devices=devices):
        torch.manual_seed(child_seed(seed, *purpose))
        yield
