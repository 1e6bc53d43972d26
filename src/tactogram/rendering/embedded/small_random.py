"""Random numbers that a microcontroller draws to the bit: sfc32, and normal numbers as sums of four uniform ones.

References
----------
- Doty-Humphrey, C. (2010). PractRand. Generator sfc32: three additions, two shifts and a rotation per 32 bits.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

WORD = 0xFFFFFFFF
DISCARDED = 12
"""Numbers between seeding and use."""
SCALE = math.sqrt(3) / 65536
"""Of the sum of four 16-bit numbers, without its mean, to the variance 1."""
MEAN = 2 * 65535


class SmallRandom:
    """Stream ``stream`` of a seed, both 32 bits: ``a`` is the seed, ``b`` the stream, ``c`` 0, the counter 1.

    Normal numbers have no value beyond 3.46 standard deviations, and an excess kurtosis of -0.3.
    """

    def __init__(self, seed: int, stream: int) -> None:
        self._a, self._b, self._c, self._counter = seed & WORD, stream & WORD, 0, 1
        for _ in range(DISCARDED):
            self.word()

    def word(self) -> int:
        """Return the next 32 bits."""
        found = (self._a + self._b + self._counter) & WORD
        self._counter = (self._counter + 1) & WORD
        self._a = self._b ^ (self._b >> 9)
        self._b = (self._c + (self._c << 3)) & WORD
        self._c = (((self._c << 21) | (self._c >> 11)) + found) & WORD
        return found

    def normal(self) -> float:
        """Return the next number of mean 0 and variance 1."""
        first, second = self.word(), self.word()
        total = (first & 0xFFFF) + (first >> 16) + (second & 0xFFFF) + (second >> 16)
        return (total - MEAN) * SCALE

    def standard_normal(self, *, out: NDArray[np.float64]) -> NDArray[np.float64]:
        """Fill ``out`` in C order, as numpy's generators do."""
        out[...] = np.fromiter((self.normal() for _ in range(out.size)), np.float64, out.size).reshape(
            out.shape
        )
        return out
