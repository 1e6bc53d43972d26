"""Properties that all signals, or all images, of a run share, and limits within which a condition was learned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.model.conditions import Condition
from tactogram.model.examples import Example
from tactogram.signal import Signal
from tactogram.signal.signal import Domain, check_rate

UNSAID, NOTHING = 0.01, 1e-9
"""Relative and absolute difference of numbers that count as the same."""
MOMENT_S = 0.05
"""Between the times at which a motion is looked at, s."""
_QUANTITIES = {"speed_mm_s": ("speed", " mm/s"), "force_n": ("force", " N")}


@dataclass(frozen=True)
class SignalKind:
    """Properties that all signals of a run share; saved with the weights.

    Parameters
    ----------
    rate : float, Hz
    unit : str
    axes : tuple of str
    materials : tuple of str
        The classes, sorted.
    simulated : bool
        Whether any of the training data was simulated.
    domain : {"time", "displacement"}
        Over displacement ``rate`` is in samples per mm.
    words : tuple of str
        Words of the ratings, for models that learn from ratings.
    scale : tuple of (float, float), optional
        Lowest and highest possible rating.
    """

    rate: float
    unit: str
    axes: tuple[str, ...]
    materials: tuple[str, ...] = ()
    simulated: bool = False
    domain: Domain = "time"
    words: tuple[str, ...] = ()
    scale: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_rate(self.rate)
        if self.domain not in ("time", "displacement"):
            raise ParameterError.must("domain", "be 'time' or 'displacement'", self.domain)

    def signal(self, samples: Any) -> Signal:
        """Return samples, shape (axis, time), as a signal of this kind."""
        return Signal(np.asarray(samples), self.rate, self.unit, self.axes, self.domain)

    def check(self, signal: Signal) -> None:
        """Refuse a signal of another rate, unit, set of axes or domain.

        Raises
        ------
        ParameterError
            Naming the expected properties and those of ``signal``.
        """
        got = (signal.rate, signal.unit, signal.axes, signal.domain)
        if got != (self.rate, self.unit, self.axes, self.domain):
            alike = (signal.rate, signal.unit, signal.domain) == (self.rate, self.unit, self.domain)
            renamed = alike and len(signal.axes) == len(self.axes)
            hint = f"; read it with axes {','.join(self.axes)} if these are the same" if renamed else ""
            raise ParameterError.must("signal", f"be {_properties(self)}; got {_properties(signal)}{hint}")

    def require_materials(self, model: str) -> None:
        """Refuse a kind without materials.

        Raises
        ------
        ParameterError
            Naming ``model``.
        """
        if not self.materials:
            raise ParameterError(f"{model} needs recordings with a material, got none")

    def check_all_present(self, examples: Sequence[Example]) -> None:
        """Refuse training examples without a recording of one of ``materials``.

        Raises
        ------
        ParameterError
            Naming the materials.
        """
        present = {example.material for example in examples}
        if missing := [name for name in self.materials if name not in present]:
            raise ParameterError(f"no training recording of {', '.join(missing)}; leave it out of the data")

    def by_material(self, examples: Sequence[Example]) -> dict[str, list[Example]]:
        """Return the training examples of each of ``materials``.

        Raises
        ------
        ParameterError
            If an example is of another kind or material, or a material has none.
        """
        groups: dict[str, list[Example]] = {name: [] for name in self.materials}
        for example in examples:
            if example.material not in groups:
                raise ParameterError(
                    f"recording {example.id}: material must be one of {', '.join(self.materials)}, "
                    f"got {example.material!r}"
                )
            self.check(example.signal)
            groups[example.material].append(example)
        self.check_all_present(examples)
        return groups


@dataclass(frozen=True)
class ImageKind:
    """Properties that all images of a run share; saved with the weights.

    Parameters
    ----------
    words : tuple of str
    scale : tuple of (float, float)
    items : tuple of str
        Items of the training part, sorted.
    simulated : bool
    """

    words: tuple[str, ...]
    scale: tuple[float, float]
    items: tuple[str, ...]
    simulated: bool = False

    @property
    def materials(self) -> tuple[str, ...]:
        """Empty: images have no classes."""
        return ()


Kind = SignalKind | ImageKind


def unit_scores(words: Mapping[str, float], kind: Kind, *, partial: bool = False) -> NDArray[np.float64]:
    """Return scores as 0 to 1 in the order of ``kind.words``, shape (word,): (x - 1) / 6 on the 7-point scale.

    Missing words are NaN if ``partial``.

    Raises
    ------
    ParameterError
        For an unknown or missing word, or a score off the scale.
    """
    low, high = kind.scale or (0.0, 1.0)
    for word, score in words.items():
        if word not in kind.words:
            raise ParameterError.must("words", f"be of {', '.join(kind.words)}", word, choices=kind.words)
        if not low <= score <= high:
            raise ParameterError(f"{word} must be {low:g} to {high:g}, got {score:g}")
    if not partial and (missing := [word for word in kind.words if word not in words]):
        raise ParameterError(f"a score is needed of {', '.join(missing)}")
    return np.array([(float(words.get(word, np.nan)) - low) / (high - low) for word in kind.words])


def _properties(signal: Signal | SignalKind) -> str:
    per = "Hz" if signal.domain == "time" else "samples per mm"
    return f"{signal.rate:g} {per}, {signal.unit}, axes {','.join(signal.axes)}"


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
        text = f"{what} {self.given:.4g}{unit}" + " of the given recording" * (name != self.name)
        if self.share is not None:
            towards = "up" if self.given > self.used else "down"
            text = f"a {what} of {towards} to {self.given:.4g}{unit}, for {100 * self.share:.3g} % of the motion,"
        learned = f"{'recorded' if unit else 'rated'} {self.of}".strip()
        return f"{text} is outside of what was {learned}: it counts as {self.used:.4g}{unit}"


def limits_within(
    condition: Condition, ranges: Mapping[str, tuple[float, float]], of: str = ""
) -> list[Limit]:
    """Return the speeds and forces of a condition, its motion and its vibration that are outside of ``ranges``."""
    motion, limits = condition.get("motion"), []
    for name, ends in ranges.items():
        values = [(key, condition.get(key)) for key in (name, f"vibration_{name}")]
        if motion is not None:
            times = np.linspace(0, motion.seconds, 2 + int(motion.seconds / MOMENT_S))
            gain, moved = motion.at("gain", times), motion.at(name, times)
            values.append((name, moved if gain is None or moved is None else moved[gain > 0]))
        limits += [limit for key, x in values if x is not None for limit in limits_of(key, x, ends, of)]
    return limits


def limits_of(name: str, values: ArrayLike, ends: tuple[float, float], of: str = "") -> list[Limit]:
    """Return the limits of a number, or of those of a motion, shape (time,), below and above ``ends``."""
    x, limits = np.asarray(values, np.float64), []
    for end, sign in zip(ends, (-1, 1), strict=True):
        outside = sign * (x - end) > UNSAID * abs(end) + NOTHING
        if outside.any():
            farthest = float(sign * np.max(sign * x))
            limits.append(Limit(name, farthest, float(end), of, float(outside.mean()) if x.ndim else None))
    return limits


def word_limits(words: Mapping[str, float], kind: Kind, rated: NDArray[np.floating]) -> list[Limit]:
    """Return the ``words`` outside of the scores of rated items, 0 to 1, shape (item, word), NaN if unknown."""
    low, high = kind.scale or (0.0, 1.0)
    of = "" if (low, high) == (1, 7) else f"on the ratings' scale from {low:g} to {high:g}"
    limits = []
    for word, scores in zip(kind.words, low + (high - low) * rated.T, strict=True):
        known = scores[np.isfinite(scores)]
        if low <= words.get(word, np.nan) <= high and known.size:  # a score off the scale is an error
            limits += limits_of(word, words[word], (known.min(), known.max()), of)
    return limits
