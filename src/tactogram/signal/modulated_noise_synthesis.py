"""Synthesis of modulated noise: endless, block by block, without delay and without seams."""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.signal import sosfilt

from tactogram.errors import ParameterError
from tactogram.signal.modulated_noise import (
    BANDS,
    FRAME_S,
    SCORES,
    SUBFRAMES,
    TAPS,
    ModulatedNoise,
    band_filters,
    level_factor,
)
from tactogram.signal.signal import Signal

Array = NDArray[np.float64]

SETTLING_S = 0.5
"""Synthesised and discarded at the beginning, s."""
SILENT = 1e-30
"""Least short-time power."""


class _Texture(NamedTuple):
    """Parameters of a `ModulatedNoise`, as the kernel reads them."""

    coefficients: Array  # (gain, lag x gain)
    innovation: Array  # (gain, gain)
    offset: Array  # (gain,)
    quantiles: Array  # (gain, quantile)
    coupling: Array  # (band, axis, axis)
    taps: Array  # (axis, tap)
    mixing: Array  # (axis, axis)


class _State(NamedTuple):
    """State between two samples."""

    scores: Array  # (lag, gain), the latest frame first
    before: Array  # (gain,), logarithms of the gains at the end of the last frame
    after: Array  # (gain,), at the end of the present frame
    delays: Array  # (band, axis, 2), of the band-pass filters
    power: Array  # (axis,), short-time power
    sources: Array  # (axis,), before they are mixed
    history: Array  # (axis, 2 x tap), a ring that is written twice
    place: NDArray[np.int64]  # (2,), in the ring, and the number of the subframe


class ModulatedNoiseSynthesizer:
    """An endless signal of a texture; n samples in blocks are the n samples of one call, bit for bit.

    ``seed`` (int or numpy.random.Generator) determines every sample.
    """

    def __init__(self, model: ModulatedNoise, *, seed: int | np.random.Generator) -> None:
        self.model = model
        random = np.random.default_rng(seed)
        self._innovations, self._noise = random.spawn(2)
        n, gains = len(model.axes), model.gains
        filters = band_filters(model.rate)
        self._sections = filters / _rms_of_response(filters)[:, None] ** np.array([1, 1, 1, 0, 0, 0])
        offset = model.offset_root @ random.standard_normal(gains)
        self._texture = _Texture(
            *model.regression, offset, model.quantiles, model.coupling_root, model.filter, model.mixing
        )
        self._state = _State(
            np.zeros((model.lags, gains)),
            np.zeros(gains),
            np.zeros(gains),
            np.zeros((BANDS, n, 2)),
            np.zeros(n),
            np.zeros(n),
            np.zeros((n, 2 * TAPS)),
            np.zeros(2, np.int64),
        )
        self._done = self._frame = 0
        self._factor = level_factor(model.rate)
        burn_in = self._innovations.standard_normal((10 * model.lags, gains))
        _settle(burn_in, self._texture, self._state)
        self._next(round(SETTLING_S * model.rate) + TAPS)

    def next(self, samples: int) -> Signal:
        """Return the next ``samples`` >= 1 of the signal."""
        if samples < 1:
            raise ParameterError(f"samples must be >= 1, got {samples}")
        x = self._next(samples) + self.model.mean[:, None]
        return Signal(x.astype(np.float32), self.model.rate, self.model.unit, self.model.axes)

    def _next(self, samples: int) -> Array:
        n, length = len(self.model.axes), FRAME_S * self.model.rate
        most = int(samples / length) + 2
        begins = np.floor(np.arange(self._frame, self._frame + most) * length + 0.5)
        begun = int(np.searchsorted(begins, self._done + samples))
        innovations = self._innovations.standard_normal((begun, self.model.gains))
        noise = self._noise.standard_normal((samples, BANDS, n))
        out = np.empty((n, samples))
        self._frame = _synthesise(
            noise,
            innovations,
            self._texture,
            self._state,
            self._sections,
            self._factor,
            length,
            self._done,
            self._frame,
            out,
        )
        self._done += samples
        return out


def synthesise_modulated_noise(
    model: ModulatedNoise, seconds: float, *, seed: int | np.random.Generator
) -> Signal:
    """Return ``seconds`` (at least one sample) of a texture."""
    if not (seconds > 0 and np.isfinite(seconds)):
        raise ParameterError(f"seconds must be > 0, got {seconds}")
    return ModulatedNoiseSynthesizer(model, seed=seed).next(max(1, round(seconds * model.rate)))


def _rms_of_response(sections: Array) -> Array:
    """Return each filter's rms output for white noise of variance 1, by its impulse response."""
    impulse = np.zeros(1 << 15)
    impulse[0] = 1.0
    return np.array([np.sqrt(np.sum(sosfilt(row[None], impulse) ** 2)) for row in sections])


@numba.njit(cache=True, nogil=True)
def _advance(innovation: Array, texture: _Texture, state: _State) -> None:
    """Draw the gains at the end of the next frame."""
    scores, before, after = state.scores, state.before, state.after
    lags, gains = scores.shape
    new = np.zeros(gains)
    for g in range(gains):
        for h in range(gains):
            new[g] += texture.innovation[g, h] * innovation[h]
        for k in range(lags):
            for h in range(gains):
                new[g] += texture.coefficients[g, k * gains + h] * scores[k, h]
    for k in range(lags - 1, 0, -1):
        scores[k] = scores[k - 1]
    scores[0] = new
    before[:] = after
    last = len(SCORES) - 1
    for g in range(gains):
        z = new[g] + texture.offset[g]
        i = min(max(np.searchsorted(SCORES, z), 1), last)
        share = min(max((z - SCORES[i - 1]) / (SCORES[i] - SCORES[i - 1]), 0.0), 1.0)
        after[g] = (1 - share) * texture.quantiles[g, i - 1] + share * texture.quantiles[g, i]


@numba.njit(cache=True, nogil=True)
def _settle(innovations: Array, texture: _Texture, state: _State) -> None:
    for innovation in innovations:
        _advance(innovation, texture, state)


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
    texture: _Texture,
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
    taps = texture.taps.shape[1]
    first, subframe = frame, state.place[1]
    for t in range(len(noise)):
        now = done + t
        if now == _end(frame, length):
            _advance(innovations[frame - first], texture, state)
            subframe = SUBFRAMES * frame
            frame += 1
        elif now == _end(subframe + 1, length / SUBFRAMES):
            subframe += 1
        begin, end = _end(frame - 1, length), _end(frame, length)
        of_frame = (now + 1 - begin) / (end - begin)
        begin, end = _end(subframe, length / SUBFRAMES), _end(subframe + 1, length / SUBFRAMES)
        of_subframe = (now + 1 - begin) / (end - begin)
        number = subframe - SUBFRAMES * (frame - 1)
        state.place[0] = (state.place[0] + 1) % taps
        place = state.place[0]
        for a in range(axes):
            row = a * each
            total = 0.0
            for b in range(BANDS):
                x = 0.0
                for c in range(axes):
                    x += texture.coupling[b, a, c] * noise[t, b, c]
                s, d = sections[b], state.delays[b, a]
                y = s[0] * x + d[0]
                d[0] = s[1] * x - s[4] * y + d[1]
                d[1] = s[2] * x - s[5] * y
                gain = (1 - of_frame) * state.before[row + b] + of_frame * state.after[row + b]
                total += np.exp(gain) * y
            state.power[a] += factor * (total * total - state.power[a])
            at = row + BANDS + number
            last = state.before[row + each - 1] if number == 0 else state.after[at - 1]
            level = (1 - of_subframe) * last + of_subframe * state.after[at]
            state.sources[a] = total * np.exp(level) / np.sqrt(max(state.power[a], SILENT))
        for a in range(axes):
            x = 0.0
            for c in range(axes):
                x += texture.mixing[a, c] * state.sources[c]
            ring = state.history[a]
            ring[place] = x
            ring[place + taps] = x
            out[a, t] = _dot(texture.taps[a], ring, place + taps)
    state.place[1] = subframe
    return frame
