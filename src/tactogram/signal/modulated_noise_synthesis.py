"""Synthesis of modulated noise: endless, block by block, without delay and without seams, while the texture changes."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import floor, prod
from typing import NamedTuple, TypeAlias

import numba
import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.local_amplitudes import with_local_quantiles
from tactogram.signal.modulated_noise import (
    BANDS,
    FRAME_S,
    LEVELS,
    SCORES,
    SUBFRAMES,
    TAPS,
    ModulatedNoise,
    band_filters,
    level_factor,
)
from tactogram.signal.signal import Signal
from tactogram.signal.tones import NormalSource, ToneParameters, ToneProcess, no_tones, synthesise_tones

Array = NDArray[np.float64]

Seed: TypeAlias = int | np.random.Generator | tuple[NormalSource, NormalSource, NormalSource]
SETTLING_S = 0.5
"""Synthesised and discarded at the beginning, s."""
SILENT = 1e-30
"""Least short-time power."""


class NoiseParameters(NamedTuple):
    """Parameters of the noise of a `ModulatedNoise`, as the kernel reads them."""

    rotations: Array  # (lag, 3, gain, gain)
    root: Array  # (gain, gain), of the scores' covariance
    offset_root: Array  # (gain, gain)
    quantiles: Array  # (gain, quantile)
    coupling: Array  # (band, axis, axis)
    mixing: Array  # (axis, axis)
    taps: Array  # (axis, tap)


class _State(NamedTuple):
    """State between two samples."""

    own: Array  # (gain,), normal numbers that decide the offset
    lattice: Array  # (lag, gain)
    scores: Array  # (2, gain), at the beginning and at the end of the frame
    gains: Array  # (2, 2, gain), their logarithms, by the parameters at the beginning and at the end of the samples
    delays: Array  # (band, axis, 2), of the band-pass filters
    power: Array  # (axis,), short-time power
    sources: Array  # (axis,), before they are mixed
    history: Array  # (axis, 2 x tap), a ring that is written twice
    place: NDArray[np.int64]  # (2,), in the ring, and the number of the subframe


def parameters_of(model: ModulatedNoise) -> Array:
    """Return the parameters of a model in one row, float64, shape (parameter,).

    The order is that of `NoiseParameters`, then that of `ToneParameters`.
    """
    rotations, root = model.lattice
    noise = NoiseParameters(
        rotations, root, model.offset_root, model.quantiles, model.coupling_root, model.mixing, model.filter
    )
    tones = ToneParameters(model.tones.unsteadiness, model.tones.frequency, model.tones.amplitude)
    return np.concatenate([array.ravel() for array in (*noise, *tones)])


def parameter_views(values: Array, *, axes: int, lags: int) -> tuple[NoiseParameters, ToneParameters]:
    """Return views of the arrays in a row of `parameters_of`."""
    gains = axes * (BANDS + SUBFRAMES)
    shapes: list[tuple[int, ...]] = [
        *((lags, 3, gains, gains), (gains, gains), (gains, gains), (gains, len(LEVELS))),
        *((BANDS, axes, axes), (axes, axes), (axes, TAPS), (5,)),
    ]
    lines = (len(values) - sum(map(prod, shapes))) // (1 + 2 * axes)
    shapes += [(lines,), (2, axes, lines)]
    parts = np.split(values, np.cumsum([prod(shape) for shape in shapes])[:-1])
    arrays = [part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)]
    noise = len(NoiseParameters._fields)
    return NoiseParameters(*arrays[:noise]), ToneParameters(*arrays[noise:])


class NoiseProcess:
    """Samples of modulated noise and tones whose parameters may change; in blocks they are those of one call.

    Any change is stable: the scores pass one rotation per lag, or between two textures a mean of rotations, and none of
    these makes a vector longer.

    Parameters
    ----------
    axes, lags : int
        Of the textures.
    rate : float, Hz
    seed : int, numpy.random.Generator or three NormalSource
        Determines, with the parameters, every sample. Three are the sources of the gains, the noise and the tones.
    """

    def __init__(self, axes: int, lags: int, rate: float, *, seed: Seed) -> None:
        sources = seed if isinstance(seed, tuple) else tuple(np.random.default_rng(seed).spawn(3))
        self._innovations: NormalSource = sources[0]
        self._noise: NormalSource = sources[1]
        gains = axes * (BANDS + SUBFRAMES)
        self._sections = band_sections(rate)
        self._kind = {"axes": axes, "lags": lags}
        self._ends: list[tuple[Array, tuple[NoiseParameters, ToneParameters]]] = []
        self._state = _State(
            np.zeros(gains),
            np.zeros((lags, gains)),
            np.zeros((2, gains)),
            np.zeros((2, 2, gains)),
            np.zeros((BANDS, axes, 2)),
            np.zeros(axes),
            np.zeros(axes),
            np.zeros((axes, 2 * TAPS)),
            np.zeros(2, np.int64),
        )
        self._done = self._frame = 0
        self._rate, self._length, self._factor = rate, FRAME_S * rate, level_factor(rate)
        self._tones = ToneProcess(rate, sources[2])

    def next(self, out: Array, parameters: Array) -> None:
        """Write the next samples to ``out``, float64, shape (axis, time), without a mean.

        The parameters (a row of `parameters_of`) go from those of the last call to these, sample by sample.
        """
        if not self._ends:
            self._begin(parameters)
        moving = not np.array_equal(parameters, self._ends[1][0])
        if moving:
            self._ends.reverse()
            self._ends[1][0][:] = parameters
        (noise, tones), (last_noise, last_tones) = self._ends[0 if moving else 1][1], self._ends[1][1]
        self._write(out, noise, last_noise, moving)
        self._tones.add(out, tones, last_tones, moving)

    def _begin(self, parameters: Array) -> None:
        values = [parameters.astype(np.float64), parameters.astype(np.float64)]
        self._ends = [(each, parameter_views(each, **self._kind)) for each in values]
        for array in (self._state.own, self._state.lattice):
            self._innovations.standard_normal(out=array)
        settling = np.empty((self._kind["axes"], round(SETTLING_S * self._rate) + TAPS))
        noise, _ = self._ends[1][1]
        self._write(settling, noise, noise, False)

    def _write(self, out: Array, first: NoiseParameters, last: NoiseParameters, moving: bool) -> None:
        axes, samples = out.shape
        begun = 0
        while floor((self._frame + begun) * self._length + 0.5) < self._done + samples:
            begun += 1
        innovations = np.empty((begun, len(self._state.own)))
        self._innovations.standard_normal(out=innovations)
        noise = np.empty((samples, BANDS, axes))
        self._noise.standard_normal(out=noise)
        self._frame = _synthesise(
            noise,
            innovations,
            first,
            last,
            moving,
            self._state,
            self._sections,
            self._factor,
            self._length,
            self._done,
            self._frame,
            out,
        )
        self._done += samples


def synthesise_modulated_noise(
    model: ModulatedNoise, seconds: float, *, seed: int | np.random.Generator
) -> Signal:
    """Return ``seconds`` (at least one sample) of a texture.

    They are those of a `NoiseProcess`, but have the model's local amplitudes: clicks, which depend on samples after
    them, and so are not streamed.
    """
    if not (seconds > 0 and np.isfinite(seconds)):
        raise ParameterError.must("seconds", "be > 0", seconds)
    axes, rate, count = len(model.axes), model.rate, max(1, round(seconds * model.rate))
    gains, white, wander = np.random.default_rng(seed).spawn(3)
    noise = np.empty((axes, count))
    process = NoiseProcess(axes, model.lags, rate, seed=(gains, white, wander))
    process.next(noise, parameters_of(replace(model, tones=no_tones(axes))))
    if len(model.local):
        noise = with_local_quantiles(noise, rate, model.local)
    x = noise + synthesise_tones([model.tones], count, rate, seed=wander) + model.mean[:, None]
    return Signal(x.astype(np.float32), rate, model.unit, model.axes)


@lru_cache(maxsize=32)
def band_sections(rate: float) -> Array:
    """Return `band_filters`, shape (band, 6), that make noise of variance 1 out of white noise of variance 1."""
    filters = band_filters(rate)
    impulse = np.zeros(1 << 15)
    impulse[0] = 1.0
    rms = np.array([np.sqrt(np.sum(scipy.signal.sosfilt(row[None], impulse) ** 2)) for row in filters])
    return np.asarray(filters / rms[:, None] ** np.array([1, 1, 1, 0, 0, 0]))


@numba.njit(cache=True, nogil=True, fastmath={"reassoc"})
def _advance(innovation: Array, parameters: NoiseParameters, state: _State) -> None:
    """Draw the scores at the end of the next frame."""
    lattice, scores, rotations = state.lattice, state.scores, parameters.rotations
    lags, gains = lattice.shape
    x, new = np.empty(gains), np.empty(gains)
    for g in range(gains):
        x[g] = innovation[g]
    for m in range(lags - 1, -1, -1):
        s, k, t = rotations[m, 0], rotations[m, 1], rotations[m, 2]
        for g in range(gains):
            total = 0.0
            for h in range(gains):
                total += s[g, h] * x[h] + k[g, h] * lattice[m, h]
            new[g] = total
        if m + 1 < lags:
            for g in range(gains):
                total = 0.0
                for h in range(gains):
                    total += t[g, h] * lattice[m, h]
                lattice[m + 1, g] = total
            for h in range(gains):
                for g in range(gains):
                    lattice[m + 1, g] -= k[h, g] * x[h]
        x, new = new, x
    for g in range(gains):
        lattice[0, g] = x[g]
        scores[0, g] = scores[1, g]
        scores[1, g] = 0.0
        for h in range(gains):
            scores[1, g] += parameters.root[g, h] * x[h]


@numba.njit(cache=True, nogil=True)
def _transform(parameters: NoiseParameters, state: _State, gains: Array) -> None:
    """Write the logarithms of the gains at both ends of the frame, shape (2, gain)."""
    last = len(SCORES) - 1
    for g in range(gains.shape[1]):
        offset = 0.0
        for h in range(gains.shape[1]):
            offset += parameters.offset_root[g, h] * state.own[h]
        for end in range(2):
            z = state.scores[end, g] + offset
            i = 1
            while i < last and SCORES[i] < z:
                i += 1
            share = min(max((z - SCORES[i - 1]) / (SCORES[i] - SCORES[i - 1]), 0.0), 1.0)
            q = parameters.quantiles[g]
            gains[end, g] = (1 - share) * q[i - 1] + share * q[i]


@numba.njit(cache=True, nogil=True)
def _end(count: int, length: float) -> int:
    """Return the sample after the end of ``count`` frames or subframes of ``length`` samples."""
    return int(np.floor(count * length + 0.5))


@numba.njit(cache=True, nogil=True, fastmath={"reassoc"})
def _dot(taps: Array, ring: Array, newest: int) -> float:
    total = 0.0
    for k in range(len(taps)):
        total += taps[k] * ring[newest - k]
    return total


@numba.njit(cache=True, nogil=True)
def _synthesise(
    noise: Array,  # (time, band, axis)
    innovations: Array,  # (frame, gain), of the frames that begin here
    first: NoiseParameters,  # at the beginning
    last: NoiseParameters,  # at the end
    moving: bool,  # whether they differ
    state: _State,
    sections: Array,  # (band, 6)
    factor: float,
    length: float,  # of a frame, samples
    done: int,
    frame: int,
    out: Array,  # (axis, time), written
) -> int:
    """Write the next samples, and return the number of frames that have begun."""
    axes = len(out)
    each = BANDS + SUBFRAMES
    taps = first.taps.shape[1]
    earliest, subframe = frame, state.place[1]
    g = state.gains
    _transform(first, state, g[0])
    _transform(last, state, g[1])
    for t in range(len(noise)):
        now = done + t
        if now == _end(frame, length):
            _advance(innovations[frame - earliest], last, state)
            _transform(first, state, g[0])
            _transform(last, state, g[1])
            subframe = SUBFRAMES * frame
            frame += 1
        elif now == _end(subframe + 1, length / SUBFRAMES):
            subframe += 1
        r = (t + 1) / len(noise) if moving else 0.0
        begin, end = _end(frame - 1, length), _end(frame, length)
        of_frame = (now + 1 - begin) / (end - begin)
        begin, end = _end(subframe, length / SUBFRAMES), _end(subframe + 1, length / SUBFRAMES)
        of_subframe = (now + 1 - begin) / (end - begin)
        number = subframe - SUBFRAMES * (frame - 1)
        state.place[0] = (state.place[0] + 1) % taps
        position = state.place[0]
        for a in range(axes):
            row = a * each
            total = 0.0
            for b in range(BANDS):
                x = 0.0
                for c in range(axes):
                    x += ((1 - r) * first.coupling[b, a, c] + r * last.coupling[b, a, c]) * noise[t, b, c]
                s, d = sections[b], state.delays[b, a]
                y = s[0] * x + d[0]
                d[0] = s[1] * x - s[4] * y + d[1]
                d[1] = s[2] * x - s[5] * y
                gain = _between(g, 0, row + b, 1, row + b, of_frame, r)
                total += np.exp(gain) * y
            state.power[a] += factor * (total * total - state.power[a])
            index = row + BANDS + number
            if number == 0:
                level = _between(g, 0, row + each - 1, 1, index, of_subframe, r)
            else:
                level = _between(g, 1, index - 1, 1, index, of_subframe, r)
            state.sources[a] = total * np.exp(level) / np.sqrt(max(state.power[a], SILENT))
        for a in range(axes):
            x = 0.0
            for c in range(axes):
                x += ((1 - r) * first.mixing[a, c] + r * last.mixing[a, c]) * state.sources[c]
            ring = state.history[a]
            ring[position] = x
            ring[position + taps] = x
            out[a, t] = _dot(first.taps[a], ring, position + taps)
            if moving:
                out[a, t] += r * (_dot(last.taps[a], ring, position + taps) - out[a, t])
    state.place[1] = subframe
    return frame


@numba.njit(cache=True, nogil=True)
def _between(gains: Array, one: int, i: int, two: int, j: int, share: float, r: float) -> float:
    """Return a gain between two times, ``i`` at the end ``one`` of the frame and ``j`` at ``two``."""
    before = (1 - share) * gains[0, one, i] + share * gains[0, two, j]
    after = (1 - share) * gains[1, one, i] + share * gains[1, two, j]
    return float((1 - r) * before + r * after)
