"""Traits of simulated raters: leniency, use of the scale, tactile and visual acuity."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tactogram.datasets.ratings.words import WORDS
from tactogram.errors import ParameterError

LEAN, LEAN_WORD, SPREAD, SENSITIVITY_DB, OWN_TASTE = 0.45, 0.35, 0.20, 4.0, 0.55
"""Standard deviations over people: of the bias on all words and on single ones (points of 7), of the logarithm of the
used share of the scale, of the sensitivity to vibration (dB), and of personal taste per item and word (points of 7).
Our assumptions, so that raters agree as moderately as untrained people: docs/simulated-raters.md has the figures."""
SIGHT_LEAN, SIGHT_WORD, SIGHT_TASTE = 0.5, 0.5, 0.8
"""The same for yes or no to an image, in logits."""


@dataclass(frozen=True, eq=False)
class SimulatedRater:
    """A simulated rater."""

    name: str
    seed: int  # of everything else that is random about this person
    lean: NDArray[np.float64]  # shape (word,), points of 7
    spread: float  # factor of distances from the middle of the scale
    sensitivity_db: float  # added to the level of every vibration
    yes: NDArray[np.float64]  # shape (word,), logits: readiness to call a word evoked by an image

    def rng(self, *about: str) -> np.random.Generator:
        """Return this person's random generator for some purpose, always in the same state."""
        keys = [zlib.crc32(text.encode()) for text in (self.name, *about)]
        return np.random.default_rng(np.random.SeedSequence([self.seed, *keys]))


def draw_people(count: int, *, seed: int, prefix: str = "rater") -> tuple[SimulatedRater, ...]:
    """Return ``count`` simulated people, ``rater01`` and so on; another prefix or seed gives other people."""
    if count < 1:
        raise ParameterError(f"at least one simulated rater is needed, got {count}")
    if seed < 0:
        raise ParameterError(f"seed must be >= 0, got {seed}")
    return tuple(_person(f"{prefix}{number:02d}", seed) for number in range(1, count + 1))


def _person(name: str, seed: int) -> SimulatedRater:
    rng = np.random.default_rng(np.random.SeedSequence([seed, zlib.crc32(name.encode())]))
    draw = rng.standard_normal
    return SimulatedRater(
        name,
        seed,
        LEAN * draw() + LEAN_WORD * draw(len(WORDS)),
        float(np.exp(SPREAD * draw())),
        float(SENSITIVITY_DB * draw()),
        SIGHT_LEAN * draw() + SIGHT_WORD * draw(len(WORDS)),
    )
