"""Answers that ignore what is given: a random training item, and the mean of the training items.

A model that is not better than both does not show that it uses its input. Both are of the speed and force that are
asked, where there are training items of these: they ignore the surface or the words alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from tactogram.benchmark.data import OpenTask
from tactogram.benchmark.questions import Answers, Question
from tactogram.benchmark.task_kind import Baseline, Content, kind_of
from tactogram.model import Condition
from tactogram.signal import Image, Signal
from tactogram.training.seeds import child_rng

LONGEST_SEGMENT = 1024
"""Samples of a segment of Welch's method."""
LEAST_POWER = 1e-12
"""Of the largest in a spectrum: its logarithm stands for silence."""


def array_of(content: Content, seconds: float | None = None) -> NDArray[Any]:
    """Return samples, pixels or scores; samples are repeated up to ``seconds``, if given."""
    if not isinstance(content, Signal):
        return content.pixels if isinstance(content, Image) else content
    if seconds is None:
        return content.samples
    return content.samples.take(range(int(np.ceil(seconds * content.rate))), axis=1, mode="wrap")


def _alike(items: Sequence[tuple[Condition, Content]], given: Condition) -> list[Content]:
    """Return the items of the speed and force that are given; all, if there are none of these."""
    wanted = {name: given[name] for name in ("speed_mm_s", "force_n") if name in given}
    found = [of for condition, of in items if all(condition.get(n) == wanted[n] for n in wanted)]
    return found or [of for _, of in items]


def _random(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    items, found = kind_of(opened.task.kind).training_items(opened), {}
    for question in questions:
        rng, alike = child_rng(seed, "benchmark", "random", question.id), _alike(items, question.given)
        found[question.id] = array_of(alike[int(rng.integers(len(alike)))], question.seconds)
    return found


@dataclass(frozen=True, eq=False)
class _Noise:
    """Gaussian noise of the mean log spectrum and the mean of signals."""

    power: NDArray[np.float64]  # axis, frequency; per Hz
    offset: NDArray[np.float64]  # axis
    rate: float
    seconds: float

    @classmethod
    def of(cls, signals: Sequence[Signal]) -> Self:
        size = min(LONGEST_SEGMENT, *map(len, signals))
        power = np.array([welch(each.samples, each.rate, nperseg=size)[1] for each in signals])
        least = np.maximum(LEAST_POWER * power.max((1, 2), keepdims=True), np.finfo(float).tiny)
        return cls(
            np.exp(np.log(np.maximum(power, least)).mean(0)),
            np.mean([each.samples.mean(1) for each in signals], axis=0),
            signals[0].rate,
            float(np.median([each.extent for each in signals])),
        )

    def draw(self, seconds: float | None, rng: np.random.Generator) -> NDArray[np.float64]:
        """Return samples, float64, shape (axis, time)."""
        samples = int(np.ceil((seconds or self.seconds) * self.rate))
        white = np.fft.rfft(rng.standard_normal((len(self.power), samples)))
        places = np.linspace(0, self.power.shape[1] - 1, white.shape[1])
        power = [np.interp(places, np.arange(len(row)), row) for row in self.power]
        return (
            np.fft.irfft(white * np.sqrt(np.multiply(power, self.rate / 2)), samples) + self.offset[:, None]
        )


def _mean(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    """Return mean scores, mean pixels, or noise like the mean signal."""
    items = kind_of(opened.task.kind).training_items(opened)
    means: dict[tuple[Any, ...], Any] = {}
    found = {}
    for question in questions:
        key = question.given.get("speed_mm_s"), question.given.get("force_n")
        if key not in means:
            alike = _alike(items, question.given)
            signals = [each for each in alike if isinstance(each, Signal)]
            means[key] = _Noise.of(signals) if signals else np.nanmean([*map(array_of, alike)], axis=0)
        mean, rng = means[key], child_rng(seed, "benchmark", "mean", question.id)
        found[question.id] = mean.draw(question.seconds, rng) if isinstance(mean, _Noise) else mean
    return found


IGNORING: Mapping[str, Baseline] = {"random": _random, "mean": _mean}
"""Rows that ignore what is given, by name; unlike other baselines they have several seeds."""
