"""Tones of a texture: spectral lines that follow the speed of the finger.

Ribs, weaves and meshes are periodic. At a constant speed they are felt as sinusoids at multiples of their spatial
frequencies times the speed, in fixed phase to each other. No finger is perfectly steady, so all lines wander and swell
together: the logarithms of the speed and of a gain are first-order autoregressions, the former around a mean that
differs between strokes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError

Array = NDArray[np.float64]

STEP_S = 0.01
"""Time between two drawn values of speed and gain."""
NARROWEST_HZ = 4.0
"""Least standard deviation of a line in a spectrum."""
SAME = 1e-6
"""Relative difference of frequencies, below which two lines are one."""


@dataclass(frozen=True, eq=False)
class Tones:
    """Lines of one texture.

    Parameters
    ----------
    frequency : float64 array, shape (line,)
        Hz, at the mean speed of the recordings.
    amplitude : float64 array, shape (2, axis, line)
        Cosine and negative sine parts of each line where the pattern begins, in the texture's unit.
    unsteadiness : float64 array, shape (5,)
        Standard deviation of the mean logarithm of the speed over strokes; standard deviation of the logarithm within
        a stroke, and its autocorrelation over `STEP_S`; the same two of the logarithm of the gain.
    """

    frequency: Array
    amplitude: Array
    unsteadiness: Array

    def __post_init__(self) -> None:
        lines = len(self.frequency)
        if (
            self.amplitude.ndim != 3
            or self.amplitude.shape[::2] != (2, lines)
            or self.unsteadiness.shape != (5,)
        ):
            raise ParameterError(
                f"tones of {lines} lines need amplitudes (2, axis, {lines}) and 5 numbers of unsteadiness, got "
                f"{self.amplitude.shape} and {self.unsteadiness.shape}"
            )

    @property
    def power(self) -> Array:
        """Mean square of each axis, shape (axis,)."""
        return np.asarray(
            0.5 * np.exp(2 * self.unsteadiness[3] ** 2) * np.sum(self.amplitude**2, axis=(0, 2))
        )

    def power_spectrum(self, frequencies: Array) -> Array:
        """Return the power spectral density, unit^2/Hz, shape (axis, frequency): each line as wide as it wanders."""
        width = np.maximum(NARROWEST_HZ, self.frequency * np.hypot(*self.unsteadiness[:2]))[:, None]
        shape = scipy.stats.norm.pdf(frequencies, self.frequency[:, None], width)
        return np.asarray(
            0.5 * np.exp(2 * self.unsteadiness[3] ** 2) * np.sum(self.amplitude**2, axis=0) @ shape
        )

    def moved(self, ratio: float, band: Array) -> Tones:
        """Return the lines at ``ratio`` times the speed; those outside ``band`` (Hz, shape (2,)) are silent."""
        frequency = self.frequency * ratio
        inside = (frequency >= band[0]) & (frequency <= band[1])
        return replace(self, frequency=frequency, amplitude=self.amplitude * inside)

    def at_its_own_speed(self) -> Tones:
        """Return the lines without the spread of mean speeds between strokes."""
        return replace(self, unsteadiness=self.unsteadiness * (np.arange(5) > 0))

    def scaled(self, gain: Array) -> Tones:
        """Return the lines with the amplitude of each axis multiplied by ``gain``, shape (axis,)."""
        return replace(self, amplitude=self.amplitude * gain[:, None])

    def summed(self, chosen: Sequence[bool]) -> Tones:
        """Return one axis with the power of the chosen ones in each line, in the phase of their sum."""
        amplitude = self.amplitude[:, list(chosen)]
        size, total = np.sqrt(np.sum(amplitude**2, axis=(0, 1))), amplitude.sum(1)  # line; 2, line
        length = np.hypot(*total)
        phase = np.where(length > 0, total, [[1.0], [0.0]]) / np.where(length > 0, length, 1.0)
        return replace(self, amplitude=(size * phase)[:, None])


ARRAYS = tuple(field.name for field in fields(Tones))


def no_tones(axes: int) -> Tones:
    """Return tones without a line."""
    return Tones(np.zeros(0), np.zeros((2, axes, 0)), np.zeros(5))


def join_tones(tones: Sequence[Tones], weights: ArrayLike) -> Tones:
    """Return the lines of all, one after the other, with their amplitudes weighted."""
    w = np.asarray(weights, np.float64)
    every = np.concatenate([each.frequency for each in tones])
    amplitude = np.concatenate(
        [share * each.amplitude for share, each in zip(w, tones, strict=True)], axis=-1
    )
    having = np.array([share if len(each.frequency) else 0.0 for share, each in zip(w, tones, strict=True)])
    unsteadiness = (
        having @ np.array([each.unsteadiness for each in tones]) / max(having.sum(), np.finfo(float).tiny)
    )
    return Tones(every, amplitude, unsteadiness)


def mix_tones(tones: Sequence[Tones], weights: ArrayLike) -> Tones:
    """Return the lines of all, ascending, with their amplitudes weighted; lines of one frequency are added."""
    joined = join_tones(tones, weights)
    every, amplitude = joined.frequency, joined.amplitude
    order = np.argsort(every, kind="stable")
    first = np.ones(len(every), bool)
    first[1:] = np.diff(every[order]) > SAME * every[order][1:]
    line = np.cumsum(first) - 1
    added = amplitude[..., order] @ (line[:, None] == np.arange(first.sum()))
    return Tones(every[order][first], added, joined.unsteadiness)


def share_pattern(tones: Sequence[Tones], speeds: ArrayLike, band: Array) -> list[Tones]:
    """Return the lines of strokes of one surface as one pattern, at the speed and with the power of each stroke.

    The pattern is that of the stroke with the strongest lines. The others may have crossed the surface in another
    direction, so only their power is kept. ``speeds`` (mm/s) are NaN where unknown; lines outside ``band`` (Hz, shape
    (2,)) are silent.
    """
    power = np.array([each.power.sum() for each in tones])
    if len(tones) == 1 or not power.any():
        return list(tones)
    place = int(np.argmax(power))
    pattern, own = tones[place], tones[place].power
    ratio = np.nan_to_num(np.asarray(speeds, np.float64) / np.asarray(speeds, np.float64)[place], nan=1.0)
    found = []
    for each, times in zip(tones, ratio, strict=True):
        gain = np.sqrt(each.power / np.where(own > 0, own, 1.0))
        found.append(pattern.moved(float(times), band).scaled(gain))
    return found
