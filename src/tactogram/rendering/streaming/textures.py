"""An autoregressive texture that follows speed and force within a block.

At the beginning and at the end of each block a `TextureTable` is asked; within it the ladder of
`tactogram.signal.synthesis` goes from the one's parameters to the other's, sample by sample.
"""

from __future__ import annotations

from typing import Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.rendering.streaming.finger_path import MotionBlock
from tactogram.rendering.streaming.texture_table import TextureTable, between
from tactogram.signal.synthesis import ladder

Array = NDArray[np.float64]
Block = NDArray[np.float32]

LONGEST_KERNEL = 8
"""Most samples of a texture on each side of the one that is interpolated."""
KERNEL_S = 0.004
"""How far the kernel may look ahead, s, as long as it has three samples on each side."""
PHASES = 128
"""Places between two samples for which the kernel is tabulated; in between it is interpolated."""


class StreamingTexture(Protocol):
    """A texture that is asked for block after block.

    Attributes
    ----------
    name : str
    unit : str
    axes : tuple of str
    delay_s : float
        By how much it answers a change of the motion later than at once.
    holds_at_rest : bool
        Whether it has a value where the finger rests (a friction coefficient) or fades out (a vibration).
    level : float
        Root mean square at a medium speed and force, in ``unit``: what a landing is scaled by.
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


class AutoregressiveTexture:
    """A `TextureTable` as an endless signal at the engine's rate.

    The mean of the models is left out: it is gravity, or the sensor's.

    Parameters
    ----------
    name : str
    table : TextureTable
    rate : float
        Of the engine, Hz.
    most : int
        Most samples in a block.
    seed : int
        Decides the noise.

    Attributes
    ----------
    half : int
        Samples of the table's rate on each side of the one that is interpolated; 0 where the rates are the same.
    kernel : float64 array, shape (PHASES + 1, 2 half)
        Their weights: row p is for a place p / PHASES past a sample.
    """

    holds_at_rest = False

    def __init__(self, name: str, table: TextureTable, *, rate: float, most: int, seed: int) -> None:
        self.name, self.unit, self.axes = name, table.unit, table.axes
        self._table = table
        self._random = np.random.default_rng(seed)
        n, order = len(table.axes), table.reflection.shape[-1]
        self._state = np.ascontiguousarray(table.root[0, 0] @ self._random.standard_normal((n, order)))
        self._ratio = table.rate / rate
        self.half = 0
        self.kernel = np.zeros((PHASES + 1, 0))
        if self._ratio != 1:
            self.half = max(3, min(LONGEST_KERNEL, round(KERNEL_S * table.rate)))
            reach = self.half * max(
                1.0, self._ratio
            )  # the kernel widens where the texture has more than fits
            self.half = int(np.ceil(reach))
            self.kernel = _sinc(self.half, min(1.0, 1 / self._ratio))
        self.delay_s = self.half / table.rate
        room = 2 * self.half + int(np.ceil(most * self._ratio)) + 2
        self._noise = np.zeros((room, n))
        self._made = np.zeros((n, room))
        self._history = np.zeros((n, room))
        self._have = 0
        self._place = float(max(self.half - 1, 0))
        # Parameters at the beginning and at the end of a block.
        self._reflection = np.zeros((2, n, order))
        self._deviation = np.zeros((2, n))
        self._mean = np.zeros((2, n))
        self._root = np.zeros((2, n, n))
        middle = np.exp(table.deviation[len(table.speeds) // 2, len(table.forces) // 2])
        self.level = float(np.sqrt(np.sum(middle**2)))
        self._begun = False

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``, float32, shape (axis, most)."""
        count = motion.count
        last = int(self._place + (count - 1) * self._ratio) + self.half
        new = max(0, last + 1 - self._have) if self.half else count
        self._random.standard_normal(out=self._noise[:new])
        t = self._table
        self._have, self._place = _render(
            motion.speed_mm_s[count - 1],
            motion.force_n[count - 1],
            t.speeds,
            t.forces,
            t.reflection,
            t.deviation,
            t.root,
            self._reflection,
            self._deviation,
            self._mean,
            self._root,
            self._begun,
            self._noise,
            self._state,
            self._made,
            new,
            self._history,
            self._have,
            self._place,
            self._ratio,
            self.half,
            self.kernel,
            count,
            out,
        )
        self._begun = True


def _sinc(half: int, cutoff: float) -> Array:
    """Return a Kaiser-windowed sinc, shape (PHASES + 1, 2 half): row p is for a place p / PHASES past a sample."""
    at = np.arange(-half + 1, half + 1) - np.arange(PHASES + 1)[:, None] / PHASES
    inside = np.clip(1 - (at / half) ** 2, 0, None)
    kernel = cutoff * np.sinc(cutoff * at) * np.i0(6.0 * np.sqrt(inside)) / np.i0(6.0)
    return np.asarray(kernel / kernel.sum(axis=1, keepdims=True))


@numba.njit(cache=True, nogil=True)
def _render(
    speed: float,
    force: float,
    speeds: Array,
    forces: Array,
    reflections: Array,
    deviations: Array,
    roots: Array,
    reflection: Array,  # (2, axis, order): before and after
    deviation: Array,  # (2, axis)
    mean: Array,  # (2, axis), zeros
    root: Array,  # (2, axis, axis)
    begun: bool,
    noise: Array,  # (room, axis)
    state: Array,
    made: Array,  # (axis, room)
    new: int,
    history: Array,  # (axis, room)
    have: int,
    place: float,
    ratio: float,
    half: int,
    kernel: Array,  # (PHASES + 1, 2 half)
    count: int,
    out: Block,
) -> tuple[int, float]:
    reflection[0], deviation[0], root[0] = reflection[1], deviation[1], root[1]
    between(
        speed, force, speeds, forces, reflections, deviations, roots, reflection[1], deviation[1], root[1]
    )
    if not begun:
        reflection[0], deviation[0], root[0] = reflection[1], deviation[1], root[1]
    axes = len(made)
    ladder(noise[:new], state, reflection, deviation, mean, root, 0, max(1, new), made[:, :new])
    if half == 0:
        for a in range(axes):
            for i in range(count):
                out[a, i] = made[a, i]
        return 0, 0.0
    history[:, have : have + new] = made[:, :new]
    have += new
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
        done = min(done, have)
        for a in range(axes):
            for i in range(have - done):
                history[a, i] = history[a, i + done]
        have -= done
        place -= done
    return have, place
