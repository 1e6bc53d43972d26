"""Autoregressive textures that follow speed and force within a block.

A `TextureTable` gives the parameters at the end of each block; within the block the ladder of
`tactogram.signal.synthesis` goes from the previous ones to these, sample by sample.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.rendering.streaming.finger_path import MotionBlock
from tactogram.rendering.streaming.texture_table import TextureGrid, TextureTable, interpolate
from tactogram.signal.synthesis import ladder

Array = NDArray[np.float64]
Block = NDArray[np.float32]

LONGEST_KERNEL = 8
"""Largest number of samples on each side of the interpolated one."""
KERNEL_S = 0.004
"""How far the kernel may look ahead, s, but at least three samples on each side."""
PHASES = 128
"""Places between two samples for which the kernel is tabulated; it is interpolated in between."""


class StreamingTexture(Protocol):
    """A texture that is rendered block after block, with a delay of ``delay_s`` in its response to motion.

    ``holds_at_rest`` is whether it has a value while the finger rests (a friction coefficient) or fades out (a
    vibration). ``level`` is its root mean square at a medium speed and force, in ``unit``; landings are scaled by it.
    """

    name: str
    unit: str
    axes: tuple[str, ...]
    delay_s: float
    holds_at_rest: bool
    level: float

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``, float32, shape (axis, most)."""
        ...


class _Filter(NamedTuple):
    """State of the ladder, and its parameters at the beginning and at the end of a block."""

    state: Array  # (axis, order)
    reflection: Array  # (2, axis, order)
    deviation: Array  # (2, axis)
    mean: Array  # (2, axis), zeros
    root: Array  # (2, axis, axis)


class _Resampler(NamedTuple):
    """Samples at the table's rate, new and past, and the kernel that interpolates them at the engine's rate."""

    samples: Array  # (axis, room)
    history: Array  # (axis, room)
    ratio: float
    half: int
    kernel: Array  # (PHASES + 1, 2 half)


class AutoregressiveTexture:
    """A `TextureTable` as an endless signal at the engine's ``rate`` (Hz), in blocks of at most ``most`` samples.

    The mean of the models is omitted: it is gravity, or the sensor's. ``half`` is the number of samples at the table's
    rate on each side of the interpolated one, 0 if the rates are equal; ``kernel`` their weights.
    """

    holds_at_rest = False

    def __init__(self, name: str, table: TextureTable, *, rate: float, most: int, seed: int) -> None:
        self.name, self.unit, self.axes = name, table.unit, table.axes
        self._table = table
        self._random = np.random.default_rng(seed)
        n, order, grid = len(table.axes), table.order, table.grid
        state = np.ascontiguousarray(grid.root[0, 0] @ self._random.standard_normal((n, order)))
        self._ratio = table.rate / rate
        self.half = 0
        self.kernel = np.zeros((PHASES + 1, 0))
        if self._ratio != 1:
            self.half = max(3, min(LONGEST_KERNEL, round(KERNEL_S * table.rate)))
            # The kernel widens where the texture's rate is the higher one.
            self.half = int(np.ceil(self.half * max(1.0, self._ratio)))
            self.kernel = _sinc(self.half, min(1.0, 1 / self._ratio))
        self.delay_s = self.half / table.rate
        room = 2 * self.half + int(np.ceil(most * self._ratio)) + 2
        self._noise = np.zeros((room, n))
        self._filter = _Filter(
            state, np.zeros((2, n, order)), np.zeros((2, n)), np.zeros((2, n)), np.zeros((2, n, n))
        )
        self._resampler = _Resampler(
            np.zeros((n, room)), np.zeros((n, room)), self._ratio, self.half, self.kernel
        )
        self._available = 0
        self._place = float(max(self.half - 1, 0))
        middle = np.exp(grid.deviation[len(grid.speeds) // 2, len(grid.forces) // 2])
        self.level = float(np.sqrt(np.sum(middle**2)))
        self._begun = False

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``."""
        count = motion.count
        last = int(self._place + (count - 1) * self._ratio) + self.half
        new = max(0, last + 1 - self._available) if self.half else count
        self._random.standard_normal(out=self._noise[:new])
        speed, force, grid = motion.speed_mm_s[count - 1], motion.force_n[count - 1], self._table.grid
        if not self._begun:
            _advance(speed, force, grid, self._filter)
            self._begun = True
        self._available, self._place = _render(
            speed,
            force,
            grid,
            self._filter,
            self._noise[:new],
            self._resampler,
            self._available,
            self._place,
            count,
            out,
        )


def _sinc(half: int, cutoff: float) -> Array:
    """Return a Kaiser-windowed sinc, shape (PHASES + 1, 2 half): row p is for a place p / PHASES past a sample."""
    at = np.arange(-half + 1, half + 1) - np.arange(PHASES + 1)[:, None] / PHASES
    inside = np.clip(1 - (at / half) ** 2, 0, None)
    kernel = cutoff * np.sinc(cutoff * at) * np.i0(6.0 * np.sqrt(inside)) / np.i0(6.0)
    return np.asarray(kernel / kernel.sum(axis=1, keepdims=True))


@numba.njit(cache=True, nogil=True)
def _advance(speed: float, force: float, grid: TextureGrid, filter: _Filter) -> None:
    """Move the parameters at the end of the last block to the beginning, and write those of the new end."""
    reflection, deviation, root = filter.reflection, filter.deviation, filter.root
    reflection[0], deviation[0], root[0] = reflection[1], deviation[1], root[1]
    interpolate(speed, force, grid, reflection[1], deviation[1], root[1])


@numba.njit(cache=True, nogil=True)
def _render(
    speed: float,
    force: float,
    grid: TextureGrid,
    filter: _Filter,
    noise: Array,  # (new, axis)
    resampler: _Resampler,
    available: int,
    place: float,
    count: int,
    out: Block,
) -> tuple[int, float]:
    """Filter the noise and write ``count`` resampled samples; return the length of the history and the place in it."""
    _advance(speed, force, grid, filter)
    new = len(noise)
    samples, history = resampler.samples, resampler.history
    ratio, half, kernel = resampler.ratio, resampler.half, resampler.kernel
    axes = len(samples)
    ladder(
        noise,
        filter.state,
        filter.reflection,
        filter.deviation,
        filter.mean,
        filter.root,
        0,
        max(1, new),
        samples[:, :new],
    )
    if half == 0:
        out[:, :count] = samples[:, :count]
        return 0, 0.0
    history[:, available : available + new] = samples[:, :new]
    available += new
    taps = 2 * half
    for i in range(count):
        at = place + i * ratio
        whole = int(at)
        phase = (at - whole) * PHASES
        row = int(phase)
        share = phase - row
        for a in range(axes):
            total = 0.0
            for k in range(taps):
                weight = (1 - share) * kernel[row, k] + share * kernel[row + 1, k]
                total += weight * history[a, whole - half + 1 + k]
            out[a, i] = total
    place += count * ratio
    done = int(place) - half + 1
    if done > 0:
        done = min(done, available)
        for a in range(axes):
            for i in range(available - done):
                history[a, i] = history[a, i + done]
        available -= done
        place -= done
    return available, place
