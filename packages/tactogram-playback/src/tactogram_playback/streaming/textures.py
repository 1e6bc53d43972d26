"""Textures of a stream: surfaces over displacement, and autoregressive ones that follow speed and force.

Of the latter a `TextureTable` gives the parameters at the end of each block; within the block the ladder of
`tactogram.signal.synthesis` goes from the previous ones to these, sample by sample.

A pattern of k cycles per mm under a finger at v mm/s is felt at v k Hz. Greenspon et al. (2020) find in skin
vibrations that speed scales the whole spectrum along frequency and that this accounts for the rise of intensity, so no
further gain by speed is added. The surface is a loop: its end is crossfaded into its beginning, so that a finger can
move on endlessly in both directions. What a fast finger would shift above half the engine's rate is removed in
advance (`tactogram.rendering.drive.path_playback`).

References
----------
- Greenspon, C. M., McLellan, K. R., Lieber, J. D. & Bensmaia, S. J. (2020). Effect of scanning speed on
  texture-elicited vibrations. J. R. Soc. Interface 17, 20190892. doi 10.1098/rsif.2019.0892
"""

from __future__ import annotations

from typing import Literal, NamedTuple, Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError, Remedy
from tactogram.rendering import OVERSAMPLED, MotionBlock, band_limited, copy_count, play_loop
from tactogram.signal import Signal, join, ladder, over_displacement
from tactogram_playback.streaming.texture_table import TextureGrid, TextureTable, interpolate

Along = Literal["path", "x", "y"]

CROSSFADE = 0.1
"""Share of a surface's length over which its end and its beginning are crossfaded."""
MOST_NODES = 20_000_000
"""Largest table, nodes of all copies and axes: 80 MB."""
Array = NDArray[np.float64]
Block = NDArray[np.float32]
LONGEST_KERNEL = 8
"""Largest number of samples on each side of the interpolated one."""
KERNEL_S = 0.004
"""How far the kernel may look ahead, s, but at least three samples on each side."""
PHASES = 128
"""Places between two samples for which the kernel is tabulated; it is interpolated in between."""


class SurfaceTexture:
    """A signal over displacement, played at the finger's position by an engine at ``rate`` (Hz).

    A signal over time needs ``speed_mm_s``, at which it was recorded or generated. It is played along the finger's
    path, which never goes back, or along a coordinate: then the same position always feels the same, and a stroke back
    plays it in reverse. It is `looped`, unless it is one period already (``periodic``), which begins at position 0. Its
    ``nodes``, float32, shape (copy, axis, node), are the ``loop``, oversampled; the band of each copy ends half an
    octave below that of the previous one. Raises `ParameterError` if the speed is missing, or the surface is shorter
    than 20 samples or too long.
    """

    delay_s = 0.0

    def __init__(
        self,
        name: str,
        signal: Signal,
        *,
        rate: float,
        speed_mm_s: float | None = None,
        along: Along = "path",
        periodic: bool = False,
    ) -> None:
        if along not in ("path", "x", "y"):
            raise ParameterError.must("along", "be path, x or y", along)
        if signal.domain == "time":
            if speed_mm_s is None:
                remedy = Remedy("state the speed at which it was recorded or generated with", "speed_mm_s")
                raise ParameterError(f"{name} is over time", remedy=remedy)
            signal = over_displacement(signal, speed_mm_s)
        self.name, self.unit, self.axes, self.along = name, signal.unit, signal.axes, along
        self.holds_at_rest = signal.unit == "1"
        self.signal = signal
        """The signal over displacement."""
        self.loop = loop = signal if periodic else looped(signal)
        """One period, over displacement."""
        self.length_mm = loop.length_mm
        copies = copy_count(signal.rate, rate)
        if copies * loop.samples.size * OVERSAMPLED > MOST_NODES:
            raise ParameterError(
                f"{name} is too long for a stream: {signal.length_mm:g} mm at {signal.rate:g} samples per mm; cut it "
                "or lower its rate"
            )
        self.nodes = band_limited(loop.samples, copies)
        self.nodes_per_mm = loop.rate * OVERSAMPLED
        self.samples_per_speed = signal.rate / rate
        variance = np.var(loop.samples.astype(np.float64), axis=1)
        self.level = float(np.sqrt(variance.sum()))

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``, float32, shape (axis, most)."""
        position = {"path": motion.path_mm, "x": motion.x_mm, "y": motion.y_mm}[self.along]
        tables = self.nodes, position, motion.speed_mm_s
        play_loop(*tables, self.nodes_per_mm, self.samples_per_speed, motion.count, out)


def looped(signal: Signal) -> Signal:
    """Return ``signal`` as a loop: its end crossfaded into its beginning, at the lag where the two match best.

    Raises `ParameterError` if it is shorter than 20 samples.
    """
    length = len(signal)
    if length < 20:
        raise ParameterError(f"a surface must have at least 20 samples to be looped, got {length}")
    fade = max(2, round(CROSSFADE * length))
    head = signal.cut(0, 2 * fade + 1)
    joined = join([signal, head], overlap_s=fade / signal.rate, search_s=fade / signal.rate)
    lag = length + len(head) - fade - len(joined)
    return joined.cut(lag + fade, length)


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


class Resampler:
    """Samples at a texture's ``own`` rate, interpolated at the engine's ``rate`` (Hz), in blocks of ``most``."""

    def __init__(self, axes: int, own: float, *, rate: float, most: int) -> None:
        self._ratio = own / rate
        self.half = 0
        """Samples at the texture's rate on each side of the interpolated one; 0 if the rates are equal."""
        self.kernel = np.zeros((PHASES + 1, 0))
        """Their weights, shape (PHASES + 1, 2 half)."""
        if self._ratio != 1:
            self.half = max(3, min(LONGEST_KERNEL, round(KERNEL_S * own)))
            # The kernel widens where the texture's rate is the higher one.
            self.half = int(np.ceil(self.half * max(1.0, self._ratio)))
            self.kernel = _sinc(self.half, min(1.0, 1 / self._ratio))
        self.delay_s = self.half / own
        self.most = 2 * self.half + int(np.ceil(most * self._ratio)) + 2
        """Largest number of samples at the texture's rate in a block."""
        self._samples, self._history = np.zeros((axes, self.most)), np.zeros((axes, self.most))
        self._available, self._place = 0, float(max(self.half - 1, 0))

    def room(self, count: int) -> Array:
        """Return where to write the samples that the next ``count`` at the engine's rate need, shape (axis, time)."""
        last = int(self._place + (count - 1) * self._ratio) + self.half
        new = max(0, last + 1 - self._available) if self.half else count
        return self._samples[:, :new]

    def write(self, new: Array, count: int, out: Block) -> None:
        """Write ``count`` samples at the engine's rate, with what `room` returned."""
        if self.half == 0:
            out[:, :count] = new
            return
        self._available, self._place = _resample(
            new, self._history, self._available, self._place, self._ratio, self.half, self.kernel, count, out
        )


class AutoregressiveTexture:
    """A `TextureTable` as an endless signal at the engine's ``rate`` (Hz), in blocks of at most ``most`` samples.

    The mean of the models is omitted: it is gravity, or the sensor's.
    """

    holds_at_rest = False

    def __init__(self, name: str, table: TextureTable, *, rate: float, most: int, seed: int) -> None:
        self.name, self.unit, self.axes = name, table.unit, table.axes
        self.table = table
        self._random = np.random.default_rng(seed)
        n, order, grid = len(table.axes), table.order, table.grid
        state = np.ascontiguousarray(grid.root[0, 0] @ self._random.standard_normal((n, order)))
        self.resampler = Resampler(n, table.rate, rate=rate, most=most)
        self.delay_s = self.resampler.delay_s
        self._noise = np.zeros((self.resampler.most, n))
        self._filter = _Filter(
            state, np.zeros((2, n, order)), np.zeros((2, n)), np.zeros((2, n)), np.zeros((2, n, n))
        )
        middle = np.exp(grid.deviation[len(grid.speeds) // 2, len(grid.forces) // 2])
        self.level = float(np.sqrt(np.sum(middle**2)))
        self._begun = False

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``."""
        count = motion.count
        new = self.resampler.room(count)
        noise = self._noise[: new.shape[1]]
        self._random.standard_normal(out=noise)
        speed, force, grid = motion.speed_mm_s[count - 1], motion.force_n[count - 1], self.table.grid
        if not self._begun:
            _advance(speed, force, grid, self._filter)
            self._begun = True
        _filtered(speed, force, grid, self._filter, noise, new)
        self.resampler.write(new, count, out)


def _sinc(half: int, cutoff: float) -> Array:
    """Return a Kaiser-windowed sinc, shape (PHASES + 1, 2 half): row p is for a place p / PHASES past a sample."""
    offsets = np.arange(-half + 1, half + 1) - np.arange(PHASES + 1)[:, None] / PHASES
    inside = np.clip(1 - (offsets / half) ** 2, 0, None)
    kernel = cutoff * np.sinc(cutoff * offsets) * np.i0(6.0 * np.sqrt(inside)) / np.i0(6.0)
    return np.asarray(kernel / kernel.sum(axis=1, keepdims=True))


@numba.njit(cache=True, nogil=True)
def _advance(speed: float, force: float, grid: TextureGrid, filter: _Filter) -> None:
    """Move the parameters at the end of the last block to the beginning, and write those of the new end."""
    reflection, deviation, root = filter.reflection, filter.deviation, filter.root
    _, axes, order = reflection.shape
    for a in range(axes):
        deviation[0, a] = deviation[1, a]
        for m in range(order):
            reflection[0, a, m] = reflection[1, a, m]
        for b in range(axes):
            root[0, a, b] = root[1, a, b]
    interpolate(speed, force, grid, reflection[1], deviation[1], root[1])


@numba.njit(cache=True, nogil=True)
def _filtered(
    speed: float,
    force: float,
    grid: TextureGrid,
    filter: _Filter,
    noise: Array,  # (new, axis)
    out: Array,  # (axis, new), written
) -> None:
    _advance(speed, force, grid, filter)
    reflection, deviation, mean, root = filter.reflection, filter.deviation, filter.mean, filter.root
    ladder(noise, filter.state, reflection, deviation, mean, root, 0, max(1, len(noise)), out)


@numba.njit(cache=True, nogil=True)
def _resample(
    samples: Array,  # (axis, new)
    history: Array,  # (axis, room), changed in place
    available: int,
    position: float,
    ratio: float,
    half: int,
    kernel: Array,  # (PHASES + 1, 2 half)
    count: int,
    out: Block,  # (axis, most), written
) -> tuple[int, float]:
    """Write ``count`` interpolated samples; return the length of the history and the place in it."""
    axes, new = samples.shape
    for a in range(axes):
        for i in range(new):
            history[a, available + i] = samples[a, i]
    available += new
    taps = 2 * half
    for i in range(count):
        offset = position + i * ratio
        whole = int(offset)
        phase = (offset - whole) * PHASES
        row = int(phase)
        share = phase - row
        for a in range(axes):
            total = 0.0
            for k in range(taps):
                weight = (1 - share) * kernel[row, k] + share * kernel[row + 1, k]
                total += weight * history[a, whole - half + 1 + k]
            out[a, i] = total
    position += count * ratio
    done = int(position) - half + 1
    if done > 0:
        done = min(done, available)
        for a in range(axes):
            for i in range(available - done):
                history[a, i] = history[a, i + done]
        available -= done
        position -= done
    return available, position
