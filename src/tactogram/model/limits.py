"""Limits of conditions: numbers outside of what a model learned, and those that count in their place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.model.conditions import Condition
from tactogram.model.kinds import Kind

UNSAID, NOTHING = 0.01, 1e-9
"""Relative and absolute difference of numbers that count as the same."""
MOMENT_S = 0.05
"""Between the times at which a motion is looked at, s."""
_QUANTITIES = {"speed_mm_s": ("speed", " mm/s"), "force_n": ("force", " N")}


class Limit(NamedTuple):
    """A number of a condition, ``given``, that was not learned and counts as ``used``; ``str`` says so.

    ``of`` says of what it was not learned. Of a motion, ``share`` is that of its time, ``given`` the farthest number.
    """

    name: str
    given: float
    used: float
    of: str = ""
    share: float | None = None

    def __str__(self) -> str:
        name = self.name.removeprefix("vibration_")
        what, unit = _QUANTITIES.get(name, (name, ""))
        given = f"{what} {self.given:.4g}{unit}" + " of the given recording" * (name != self.name)
        if self.share is not None:
            towards = "up" if self.given > self.used else "down"
            given = f"a {what} of {towards} to {self.given:.4g}{unit}, for {100 * self.share:.3g} % of the motion,"
        learned = f"{'recorded' if unit else 'rated'} {self.of}".strip()
        return f"{given} is outside of what was {learned}: it counts as {self.used:.4g}{unit}"


def limits_within(
    condition: Condition, ranges: Mapping[str, tuple[float, float]], of: str = ""
) -> list[Limit]:
    """Return the speeds and forces of a condition, its motion and its vibration that are outside of ``ranges``."""
    motion, found = condition.get("motion"), []
    for name, ends in ranges.items():
        values = [(given, condition.get(given)) for given in (name, f"vibration_{name}")]
        if motion is not None:
            times = np.linspace(0, motion.seconds, 2 + int(motion.seconds / MOMENT_S))
            gain, moved = motion.at("gain", times), motion.at(name, times)
            values.append((name, moved if gain is None or moved is None else moved[gain > 0]))
        found += [limit for given, x in values if x is not None for limit in limits_of(given, x, ends, of)]
    return found


def limits_of(name: str, values: ArrayLike, ends: tuple[float, float], of: str = "") -> list[Limit]:
    """Return the limits of a number, or of those of a motion, shape (time,), below and above ``ends``."""
    x, found = np.asarray(values, np.float64), []
    for end, sign in zip(ends, (-1, 1), strict=True):
        outside = sign * (x - end) > UNSAID * abs(end) + NOTHING
        if outside.any():
            farthest = float(sign * np.max(sign * x))
            found.append(Limit(name, farthest, float(end), of, float(outside.mean()) if x.ndim else None))
    return found


def word_limits(words: Mapping[str, float], kind: Kind, rated: NDArray[np.floating]) -> list[Limit]:
    """Return the ``words`` outside of the scores of rated items, 0 to 1, shape (item, word), NaN if unknown."""
    low, high = kind.scale or (0.0, 1.0)
    of = "" if (low, high) == (1, 7) else f"on the ratings' scale from {low:g} to {high:g}"
    found = []
    for word, scores in zip(kind.words, low + (high - low) * rated.T, strict=True):
        known = scores[np.isfinite(scores)]
        if low <= words.get(word, np.nan) <= high and known.size:  # a score off the scale is an error
            found += limits_of(word, words[word], (known.min(), known.max()), of)
    return found
