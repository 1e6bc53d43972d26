"""Simulated ratings of vibrations, and stores of them."""

import numpy as np

from tactogram.datasets import Ratings, Recording, create_store
from tactogram.signal import Signal

RATE = 400.0


FACTS = {"name": "made up", "licence": "-", "simulated": True}


WORDS = ("rough", "sticky")


def vibration(level, seed):
    return Signal(level * np.random.default_rng(seed).standard_normal((1, 400)), RATE, "1", ("drive",))


def ratings_of(levels, raters=6, seed=0):
    """Simulated: rough goes by the level in dB, sticky by nothing."""
    rng = np.random.default_rng(seed)
    rows = [
        (f"r{r}", item, word, float(np.clip(np.round(mean + rng.normal(0, 0.7)), 1, 7)))
        for item, level in levels.items()
        for r in range(raters)
        for word, mean in zip(WORDS, (7 + 3 * np.log10(level), 4.0), strict=True)
    ]
    rater, item, word, value = zip(*rows, strict=True)
    return Ratings(rater, item, word, np.array(value), words=WORDS)


def rated_store(path, count=20, seed=0, change=lambda ratings: ratings):
    levels = {f"s{n:02d}": float(10 ** -np.random.default_rng([seed, n]).uniform(0, 2)) for n in range(count)}
    recordings = [
        Recording(
            streams={"drive": vibration(level, 100 * seed + n)},
            labels={"item": item},
            source=item,
            simulated=True,
        )
        for n, (item, level) in enumerate(levels.items())
    ]
    return create_store(path, recordings, ratings=change(ratings_of(levels)), **FACTS).path
