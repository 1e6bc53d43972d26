"""Tones of a texture: spectral lines that follow the speed of the finger, and their synthesis block by block.

Ribs, weaves and meshes are periodic. At a constant speed they are felt as sinusoids at multiples of their spatial
frequencies times the speed, in fixed phase to each other. No finger is perfectly steady, so all lines wander and swell
together: the logarithms of the speed and of a gain are first-order autoregressions, the former around a mean that
differs between strokes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from math import floor
from typing import Any, NamedTuple, Protocol

import numba
import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError

START_S = 0.1
"""Standard deviation of the time at which the pattern is entered, s."""
STEP_S = 0.01
"""Time between two drawn values of speed and gain."""
NARROWEST_HZ = 4.0
"""Least standard deviation of a line in a spectrum."""
SAME = 1e-6
"""Relative difference of frequencies, below which two lines are one."""


class ToneParameters(NamedTuple):
    """Arrays of `tactogram.signal.tones.Tones`, as the kernel reads them."""

    unsteadiness: Array  # (5,)
    frequency: Array  # (line,), Hz
    amplitude: Array  # (2, axis, line)


class NormalSource(Protocol):
    """A source of standard normal numbers."""

    def standard_normal(self, *, out: Array) -> Any:
        """Fill ``out``, float64, in C order."""
        ...


class ToneProcess:
    """Samples of tones whose parameters may change; n samples in blocks are the n samples of one call.

    Parameters
    ----------
    rate : float, Hz
    random : NormalSource
        E.g. a numpy.random.Generator.
    """

    def __init__(self, rate: float, random: NormalSource) -> None:
        self._random, self._rate, self._length = random, rate, STEP_S * rate
        self._drawn, self._phase = np.empty(6), np.zeros(0)
        self._done = self._frame = 0

    def add(self, out: Array, first: ToneParameters, last: ToneParameters, moving: bool) -> None:
        """Add the next samples to ``out``, (axis, time); ``moving`` if the parameters at the end are others."""
        if first.frequency.shape != last.frequency.shape:
            raise ParameterError.must(
                "tones", f"keep their lines, got {len(first.frequency)}, then {len(last.frequency)}"
            )
        if not len(first.frequency):
            return
        if not len(self._phase):
            self._random.standard_normal(out=self._drawn)
            self._phase = 2 * np.pi * first.frequency * START_S * self._drawn[5]
        samples = out.shape[1]
        begun = 0
        while floor((self._frame + begun) * self._length + 0.5) < self._done + samples:
            begun += 1
        innovations = np.empty((begun, 2))
        self._random.standard_normal(out=innovations)
        self._frame = _add(
            innovations,
            first,
            last,
            moving,
            self._drawn,
            self._phase,
            self._length,
            self._rate,
            self._done,
            self._frame,
            out,
        )
        self._done += samples


def synthesise_tones(
    tones: Sequence[Tones], samples: int, rate: float, *, seed: int | np.random.Generator
) -> Array:
    """Return ``samples`` of tones at ``rate`` (Hz), float64, shape (axis, time); all are determined by ``seed``.

    Several tones, of as many lines each, are those at evenly spaced times from the first sample to the last.
    """
    out = np.zeros((tones[0].amplitude.shape[1], samples))
    process = ToneProcess(rate, np.random.default_rng(seed))
    parameters = [ToneParameters(each.unsteadiness, each.frequency, each.amplitude) for each in tones]
    if len(parameters) == 1:
        process.add(out, parameters[0], parameters[0], False)
    edges = np.linspace(0, samples, len(parameters)).round().astype(int)
    for (first, last), (begin, end) in zip(pairwise(parameters), pairwise(edges), strict=False):
        process.add(out[:, begin:end], first, last, True)
    return out


@numba.njit(cache=True, nogil=True)
def _add(
    innovations: Array,  # (frame, 2), of the frames that begin here
    first: ToneParameters,  # at the beginning
    last: ToneParameters,  # at the end
    moving: bool,  # whether they differ
    scores: Array,  # of the stroke's speed; of speed and gain at the beginning and at the end of the frame
    phase: Array,  # (line,), radians
    length: float,  # of a frame, samples
    rate: float,
    done: int,
    frame: int,
    out: Array,  # (axis, time)
) -> int:
    """Add the next samples, and return the number of frames that have begun."""
    axes, samples = out.shape
    earliest = frame
    for t in range(samples):
        now = done + t
        if now == int(np.floor(frame * length + 0.5)):
            for which in range(2):
                kept = last.unsteadiness[2 + 2 * which]
                drawn = np.sqrt(max(0.0, 1 - kept * kept)) * innovations[frame - earliest, which]
                scores[1 + which] = scores[3 + which]
                scores[3 + which] = kept * scores[3 + which] + drawn
            frame += 1
        begin, end = np.floor((frame - 1) * length + 0.5), np.floor(frame * length + 0.5)
        of_frame = (now + 1 - begin) / (end - begin)
        r = (t + 1) / samples if moving else 0.0
        speed = (1 - of_frame) * scores[1] + of_frame * scores[3]
        level = (1 - of_frame) * scores[2] + of_frame * scores[4]
        u, v = first.unsteadiness, last.unsteadiness
        logarithm = ((1 - r) * u[0] + r * v[0]) * scores[0] + ((1 - r) * u[1] + r * v[1]) * speed
        step = 2 * np.pi / rate * np.exp(logarithm)
        gain = np.exp(((1 - r) * u[3] + r * v[3]) * level)
        for k in range(len(phase)):
            phase[k] = (phase[k] + step * ((1 - r) * first.frequency[k] + r * last.frequency[k])) % (
                2 * np.pi
            )
            cosine, sine = np.cos(phase[k]), np.sin(phase[k])
            for a in range(axes):
                real = (1 - r) * first.amplitude[0, a, k] + r * last.amplitude[0, a, k]
                imaginary = (1 - r) * first.amplitude[1, a, k] + r * last.amplitude[1, a, k]
                out[a, t] += gain * (real * cosine - imaginary * sine)
    return frame


Array = NDArray[np.float64]


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
    strongest = int(np.argmax(power))
    pattern, own = tones[strongest], tones[strongest].power
    ratio = np.nan_to_num(np.asarray(speeds, np.float64) / np.asarray(speeds, np.float64)[strongest], nan=1.0)
    patterns = []
    for each, times in zip(tones, ratio, strict=True):
        gain = np.sqrt(each.power / np.where(own > 0, own, 1.0))
        patterns.append(pattern.moved(float(times), band).scaled(gain))
    return patterns
