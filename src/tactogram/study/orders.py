"""In which order things are shown: drawn from a seed, counterbalanced over participants, or randomised in blocks.

Everything follows from the study's seed and the participant's number, so that a session can be replayed.
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
    """Return the generator of one purpose for one participant; other purposes never change what it draws."""
    return np.random.default_rng([seed, participant, zlib.crc32(purpose.encode()), *more])


def latin_square(n: int) -> np.ndarray:
    """Return the cyclic Latin square: int64 array, shape (row, place), each of 0 … n-1 once per row and column.

    Raises
    ------
    ParameterError
        If ``n`` is below 1.
    """
    _check(n)
    return (np.arange(n)[:, None] + np.arange(n)) % n


def williams_square(n: int) -> np.ndarray:
    """Return a Williams design: int64 array, shape (row, place).

    Besides being Latin, each follows each other equally often: once over ``n`` rows for an even ``n``, twice over
    ``2 n`` rows for an odd one. After E. J. Williams, "Experimental designs balanced for the estimation of residual
    effects of treatments", Aust. J. Sci. Res. A 2, 149-168 (1949).

    Raises
    ------
    ParameterError
        If ``n`` is below 1.
    """
    _check(n)
    zigzag = np.array([(place + 1) // 2 if place % 2 else -(place // 2) for place in range(n)])
    square = (zigzag + np.arange(n)[:, None]) % n
    return square if n % 2 == 0 or n == 1 else np.concatenate([square, square[:, ::-1]])


def ordered(
    items: Sequence[T], *, rule: Rule, repeats: int, seed: int, participant: int, purpose: str = "order"
) -> tuple[tuple[int, int, T], ...]:
    """Return (block, repeat, item) for everything that is shown to one participant, in its order.

    Parameters
    ----------
    items : sequence
    rule : {"random", "blocks", "latin", "williams", "as-listed"}
        - ``random``: all repeats of all items in one drawn order, one block.
        - ``blocks``: each repeat is a block that holds every item once, each in its own drawn order.
        - ``latin``, ``williams``: each repeat is a block; its order is a row of the square, the next one for the next
          repeat and for the next participant. Which item stands for which number is drawn once for the study.
        - ``as-listed``: block by block as given.
    repeats : int
        How often each item is shown.
    seed : int
        Of the study.
    participant : int
        Number of the participant, from 1.
    """
    _check(len(items))
    places = _places(len(items), rule, repeats, seed, participant, purpose)
    return tuple((block, repeat, items[i]) for block, repeat, i in places)


@lru_cache(maxsize=256)  # asked for at every page, and the same for all pages of a participant
def _places(
    count: int, rule: Rule, repeats: int, seed: int, participant: int, purpose: str
) -> tuple[tuple[int, int, int], ...]:
    """Return (block, repeat, which item) in the order in which they are shown."""
    if rule == "random":
        listed = [(repeat, i) for repeat in range(1, repeats + 1) for i in range(count)]
        drawn = generator(seed, participant, purpose).permutation(len(listed))
        return tuple((1, *listed[place]) for place in drawn)
    return tuple(
        (repeat, repeat, i)
        for repeat in range(1, repeats + 1)
        for i in _block(rule, count, repeat, repeats, seed, participant, purpose)
    )


def _block(
    rule: Rule, count: int, repeat: int, repeats: int, seed: int, participant: int, purpose: str
) -> list[int]:
    if rule == "as-listed":
        return list(range(count))
    if rule == "blocks":
        return [int(i) for i in generator(seed, participant, purpose, repeat).permutation(count)]
    square = latin_square(count) if rule == "latin" else williams_square(count)
    row = ((participant - 1) * repeats + repeat - 1) % len(square)
    # One relabelling for all participants: another for each would undo the balance.
    labels = generator(seed, 0, purpose).permutation(count)
    return [int(i) for i in labels[square[row]]]


def balanced_sides(count: int, rng: np.random.Generator, sides: Sequence[str] = ("A", "B")) -> list[str]:
    """Return ``count`` sides in a drawn order, each equally often; what is left over is drawn."""
    rounds = [side for _ in range(count // len(sides)) for side in sides]
    rest = rng.permutation(len(sides))[: count % len(sides)]
    listed = rounds + [sides[i] for i in rest]
    return [listed[i] for i in rng.permutation(count)]


def _check(n: int) -> None:
    if n < 1:
        raise ParameterError(f"an order needs at least 1 item, got {n}")
