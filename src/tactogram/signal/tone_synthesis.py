"""Synthesis of tones, block by block, while they change."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import floor
from typing import Any, NamedTuple, Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.tones import STEP_S, Tones

Array = NDArray[np.float64]

START_S = 0.1
"""Standard deviation of the time at which the pattern is entered, s."""


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
            raise ParameterError(
                f"tones must keep their lines, got {len(first.frequency)}, then {len(last.frequency)}"
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
