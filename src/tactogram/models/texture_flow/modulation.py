"""Random changes of strength, so that a network learns to follow more of them than its recordings have.

A simulated stroke is even; a hand swells, rattles and pauses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tactogram.model import Example
from tactogram.signal import Signal
from tactogram.training.seeds import child_rng

CROSSOVER_HZ = 60.0, 500.0
"""Range of the frequency between the two bands."""
SLOW_HZ, FAST_HZ = (0.4, 4.0), (4.0, 100.0)
"""Ranges of the corner frequencies of slow and of fast changes."""
DEEPEST = 1.0
"""Largest standard deviation of a gain's logarithm."""
SKEWED = -0.5, 0.25
"""Range of the skewness."""
STROKES_HZ = 0.7, 4.0
"""Range of a hand's strokes per second, back and forth."""
LEAST_SPEED = 0.1
"""Of a hand that turns, as a share of the fastest."""


class Modulation(NamedTuple):
    """Changes of the strength of a surface's recordings, in two bands and on two time scales.

    Attributes
    ----------
    crossover_hz : float
        Frequency between the bands.
    together : float
        Correlation of the bands' changes, 0 to 1.
    corners_hz, depths : tuple of float
        Of slow and of fast changes: corner frequency, and standard deviation of the gain's logarithm.
    skewness : float
        Share of the square of the logarithm that is added to it: pauses if negative, bursts if positive.
    strokes_hz, power : float
        Of a hand that strokes back and forth, strokes per second, and power of its speed that the gain is in proportion
        to: 0 for a hand that does not.
    """

    crossover_hz: float
    together: float
    corners_hz: tuple[float, float]
    depths: tuple[float, float]
    skewness: float
    strokes_hz: float
    power: float

    @staticmethod
    def drawn(rng: np.random.Generator) -> Modulation:
        """Return a modulation from the ranges of this module."""
        return Modulation(
            _log_uniform(rng, CROSSOVER_HZ),
            rng.random(),
            (_log_uniform(rng, SLOW_HZ), _log_uniform(rng, FAST_HZ)),
            (DEEPEST * rng.random(), DEEPEST * rng.random()),
            rng.uniform(*SKEWED),
            _log_uniform(rng, STROKES_HZ),
            max(0.0, rng.uniform(-1, 1)),
        )

    def apply(self, signal: Signal, rng: np.random.Generator) -> Signal:
        """Return a signal whose strength changes, each band of the same power as before."""
        count = len(signal)
        mean = signal.samples.mean(1, keepdims=True)
        spectrum = np.fft.rfft(signal.samples - mean)
        frequencies = np.fft.rfftfreq(count, 1 / signal.rate)
        below = 1 / (1 + (frequencies / self.crossover_hz) ** 4)
        phase = np.pi * (rng.random() + self.strokes_hz * np.arange(count) / signal.rate)
        strokes = self.power * np.log(np.maximum(np.abs(np.cos(phase)), LEAST_SPEED))
        common = [_changes(frequencies, count, corner, rng) for corner in self.corners_hz]
        samples = np.zeros(signal.samples.shape)
        for share in (below, 1 - below):
            logs = np.zeros(count)
            for corner, change, depth in zip(self.corners_hz, common, self.depths, strict=True):
                own = _changes(frequencies, count, corner, rng)
                logs += depth * (np.sqrt(self.together) * change + np.sqrt(1 - self.together) * own)
            logs += self.skewness * logs**2 / max(float(np.std(logs)), 1.0)
            band = np.fft.irfft(spectrum * share, count)
            gained = band * np.exp(logs + strokes)
            samples += gained * np.sqrt(np.mean(band**2) / max(np.mean(gained**2), np.finfo(float).tiny))
        return signal.with_samples(samples + mean)


def modulated(examples: Sequence[Example], share: float, *, seed: int) -> list[Example]:
    """Return recordings, those of a ``share`` of the materials modulated; no words are known of these."""
    modulations: dict[str, Modulation | None] = {}
    for name in dict.fromkeys(str(example.material) for example in examples):
        rng = child_rng(seed, "modulation", name)
        modulations[name] = Modulation.drawn(rng) if rng.random() < share else None
    results = []
    for number, example in enumerate(examples):
        modulation = modulations[str(example.material)]
        if modulation is None:
            results.append(example)
        else:
            signal = modulation.apply(example.signal, child_rng(seed, "modulated", number))
            results.append(replace(example, signal=signal, rated=None))
    return results


def _changes(
    frequencies: NDArray[Any], count: int, corner_hz: float, rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return Gaussian noise of unit variance, (time,), of a second-order low-pass filter's spectrum."""
    noise = np.fft.rfft(rng.standard_normal(count)) / (1 + (frequencies / corner_hz) ** 2)
    noise[0] = 0
    changes = np.fft.irfft(noise, count)
    result: NDArray[np.float64] = changes / max(float(np.std(changes)), np.finfo(float).tiny)
    return result


def _log_uniform(rng: np.random.Generator, limits: tuple[float, float]) -> float:
    return float(np.exp(rng.uniform(*np.log(limits))))
