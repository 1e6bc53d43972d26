"""Answers that ignore what is given: a random training item, and the mean of the training items.

A model that is not better than both does not show that it uses its input. Both are of the speed and force that are
asked, where there are training items of these: they ignore the surface or the words alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from tactogram.model import Condition
from tactogram.signal import Image, Signal
from tactogram.training import child_rng
from tactogram_benchmark.data import OpenTask
from tactogram_benchmark.task_kind import Answers, Baseline, Content, Question, kind_of

T = TypeVar("T")

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


def _alike(items: Sequence[tuple[Condition, T]], asked: Condition) -> list[T]:
    """Return the items of the speed and force that are given; all, if there are none of these."""
    motion = {name: asked[name] for name in ("speed_mm_s", "force_n") if name in asked}
    matches = [of for condition, of in items if all(condition.get(n) == motion[n] for n in motion)]
    return matches or [of for _, of in items]


def _random(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    items, answers = kind_of(opened.task.kind).training_items(opened), {}
    for question in questions:
        rng, alike = child_rng(seed, "benchmark", "random", question.id), _alike(items, question.given)
        answers[question.id] = array_of(alike[int(rng.integers(len(alike)))], question.seconds)
    return answers


def _mean(opened: OpenTask, questions: Sequence[Question], seed: int) -> Answers:
    """Return mean scores, mean pixels, or noise of the mean log spectrum and the mean of signals."""
    items = kind_of(opened.task.kind).training_items(opened)
    signals = [each for _, each in items if isinstance(each, Signal)]
    size = min([LONGEST_SEGMENT, *map(len, signals)])
    described = [(condition, _described(each, size)) for condition, each in items]
    seconds = float(np.median([each.extent for each in signals])) if signals else 0.0
    answers = {}
    for question in questions:
        answers[question.id] = np.nanmean(_alike(described, question.given), axis=0)
        if signals:
            rng, rate = child_rng(seed, "benchmark", "mean", question.id), signals[0].rate
            samples = int(np.ceil((question.seconds or seconds) * rate))
            answers[question.id] = _noise(answers[question.id], samples, rate, rng)
    return answers


def _described(content: Content, size: int) -> NDArray[np.float64]:
    """Return scores or pixels; of a signal the mean and the log power in each bin, shape (axis, 1 + frequency)."""
    if not isinstance(content, Signal):
        return np.asarray(array_of(content), np.float64)
    power = welch(content.samples, content.rate, nperseg=size)[1]
    least = max(LEAST_POWER * float(power.max()), np.finfo(float).tiny)
    return np.hstack([content.samples.mean(1, keepdims=True), np.log(np.maximum(power, least))])


def _noise(
    described: NDArray[np.float64], samples: int, rate: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    white = np.fft.rfft(rng.standard_normal((len(described), samples)))
    power = np.exp(described[:, 1:])
    places = np.linspace(0, power.shape[1] - 1, white.shape[1])
    gain = np.sqrt([np.interp(places, np.arange(len(row)), row * rate / 2) for row in power])
    return np.fft.irfft(white * gain, samples) + described[:, :1]


RANDOM = "random"
IGNORING: Mapping[str, Baseline] = {RANDOM: _random, "mean": _mean}
"""Rows that ignore what is given, by name; unlike other baselines they have several seeds."""
