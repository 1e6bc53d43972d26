"""Courses of effects: how strong an effect is as it begins, pulses and ends, which an endless texture lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from tactogram.model import Example
from tactogram.signal import Signal

STEP_S = 0.01
"""Time between two values, s."""
SMOOTHED_S = 0.02
"""Standard deviation of the Gaussian that smooths the power, s."""
PAUSE = 0.25
"""Strength below which an effect pauses, as a share of its rms."""
SHORTEST_S = 0.25
"""An effect that lasts no longer without its pauses keeps them, s."""


@dataclass(frozen=True, eq=False)
class Course:
    """Strength of one effect over time.

    Attributes
    ----------
    strength : float64 array, shape (step,)
        Every `STEP_S`, of mean square 1.
    seconds : float
        Length of the effect.
    """

    strength: NDArray[np.float64]
    seconds: float

    @staticmethod
    def of(signal: Signal) -> Course:
        """Return the course of a signal over time, the sum of its axes' powers."""
        x = signal.samples - signal.samples.mean(1, keepdims=True, dtype=np.float64)
        power = gaussian_filter1d(np.sum(x**2, axis=0), SMOOTHED_S * signal.rate, mode="constant")
        times = np.arange(0, signal.seconds, STEP_S)
        found = np.interp(times, np.arange(len(power)) / signal.rate, power)
        return Course(np.sqrt(found / max(found.mean(), np.finfo(float).tiny)), signal.seconds)

    def over(self, samples: int, rate: float) -> NDArray[np.float64]:
        """Return the strength at each of ``samples`` at ``rate`` (Hz); after its end the effect begins again."""
        times = np.arange(samples) / rate % self.seconds
        return np.interp(times, np.arange(len(self.strength)) * STEP_S, self.strength)

    def without(self, signal: Signal) -> Signal:
        """Return a signal of this course with a constant strength instead, and without pauses."""
        mean = signal.samples.mean(1, keepdims=True, dtype=np.float64)
        strength = self.over(len(signal), signal.rate)
        even = mean + (signal.samples - mean) / np.maximum(strength, PAUSE)
        lasting = strength > PAUSE
        if lasting.sum() > SHORTEST_S * signal.rate:
            even = even[:, lasting]
        return signal.with_samples(even.astype(np.float32))


def without_courses(examples: Sequence[Example]) -> list[Example]:
    """Return examples of constant strength, without pauses."""
    return [
        replace(example, signal=Course.of(example.signal).without(example.signal)) for example in examples
    ]
