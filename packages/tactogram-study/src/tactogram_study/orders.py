"""Orders of presentation: random, counterbalanced over participants, or randomised in blocks.

They follow from the study's seed and the participant's number, so that a session can be replayed.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from functools import lru_cache
from typing import Literal, TypeVar

import numpy as np

from tactogram.errors import ParameterError

T = TypeVar("T")
Rule = Literal["random", "blocks", "latin", "williams", "as-listed"]


def generator(seed: int, participant: int, purpose: str, *more: int) -> np.random.Generator:
    """Return the generator of one purpose for one participant; other purposes never change its draws."""
    return np.random.default_rng([seed, participant, zlib.crc32(purpose.encode()), *more])


def latin_square(n: int) -> np.ndarray:
    """Return the cyclic Latin square: int64 array, shape (row, place), each of 0 … n-1 once per row and column."""
    return (np.arange(n)[:, None] + np.arange(n)) % n


def williams_square(n: int) -> np.ndarray:
    """Return a Williams design: int64 array, shape (row, place).

    Latin, and each follows each other equally often: once over ``n`` rows for an even ``n``, twice over ``2 n`` rows
    for an odd one. After E. J. Williams, "Experimental designs balanced for the estimation of residual effects of
    treatments", Aust. J. Sci. Res. A 2, 149-168 (1949).
    """
    zigzag = np.array([(place + 1) // 2 if place % 2 else -(place // 2) for place in range(n)])
    square = (zigzag + np.arange(n)[:, None]) % n
    return square if n % 2 == 0 or n == 1 else np.concatenate([square, square[:, ::-1]])


def ordered(
    items: Sequence[T], *, rule: Rule, repeats: int, seed: int, participant: int
) -> tuple[tuple[int, int, T], ...]:
    """Return (block, repeat, item) of each trial of one participant, in order.

    - ``random``: all repeats of all items in one random order, one block.
    - ``blocks``: each repeat is a block of all items, each in its own random order.
    - ``latin``, ``williams``: each repeat is a block; its order is a row of the square, the next one for the next
      repeat and for the next participant. The numbers of the items are drawn once for the study.
    - ``as-listed``: block by block in the given order.
    """
    if not items:
        raise ParameterError("an order needs at least 1 item, got 0")
    return tuple(
        (block, repeat, items[i])
        for block, repeat, i in _places(len(items), rule, repeats, seed, participant)
    )


@lru_cache(maxsize=256)  # requested at every page, and the same for all pages of a participant
def _places(
    count: int, rule: Rule, repeats: int, seed: int, participant: int
) -> tuple[tuple[int, int, int], ...]:
    if rule == "random":
        listed = [(repeat, i) for repeat in range(1, repeats + 1) for i in range(count)]
        drawn = generator(seed, participant, "order").permutation(len(listed))
        return tuple((1, *listed[place]) for place in drawn)
    return tuple(
        (repeat, repeat, i)
        for repeat in range(1, repeats + 1)
        for i in _block(rule, count, repeat, repeats, seed, participant)
    )


def _block(rule: Rule, count: int, repeat: int, repeats: int, seed: int, participant: int) -> list[int]:
    if rule == "as-listed":
        return list(range(count))
    if rule == "blocks":
        return [int(i) for i in generator(seed, participant, "order", repeat).permutation(count)]
    square = latin_square(count) if rule == "latin" else williams_square(count)
    row = ((participant - 1) * repeats + repeat - 1) % len(square)
    # One relabelling for all participants: another for each would destroy the balance.
    labels = generator(seed, 0, "order").permutation(count)
    return [int(i) for i in labels[square[row]]]


def balanced_sides(count: int, rng: np.random.Generator, sides: Sequence[str] = ("A", "B")) -> list[str]:
    """Return ``count`` sides in random order, each equally often; the remainder is drawn."""
    rounds = [side for _ in range(count // len(sides)) for side in sides]
    rest = rng.permutation(len(sides))[: count % len(sides)]
    listed = rounds + [sides[i] for i in rest]
    return [listed[i] for i in rng.permutation(count)]
