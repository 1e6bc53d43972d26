"""An autoregressive texture that follows speed and force within a block.

`TextureMap` mixes models through their line spectral frequencies: right, and too slow for a block (1.4 ms per model
of order 40). So it is asked beforehand, on a grid over speed and force, and in between the reflection coefficients
of the four nearest nodes are interpolated. That stays stable (a mean of numbers within (-1, 1) is within) and exact at
every node; how far it is off in between is measured by `TextureTable.error_db`. Within a block the ladder of
`tactogram.signal.synthesis` goes from the parameters of its beginning to those of its end, sample by sample.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from tactogram.errors import ParameterError
from tactogram.rendering.streaming.following import MotionBlock
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.line_spectrum import reflection_of_polynomial
from tactogram.signal.synthesis import ladder
from tactogram.signal.texture_map import TextureMap

Array = NDArray[np.float64]
Block = NDArray[np.float32]

SPEEDS = 17
"""Least number of nodes over speed, where it is known."""
FORCES = 9
"""Least number of nodes over force."""
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


@dataclass(frozen=True, eq=False)
class TextureTable:
    """Models of one surface on a grid over speed and force.

    Parameters
    ----------
    speeds, forces : float64 array, shape (S,), (F,)
        Ascending, mm/s and N; one node where a surface does not know it.
    reflection : float64 array, shape (S, F, axis, order)
    deviation : float64 array, shape (S, F, axis)
        Natural logarithm of the root mean square of each axis, in ``unit``.
    root : float64 array, shape (S, F, axis, axis)
        Square root of the innovations' correlation.
    """

    speeds: Array
    forces: Array
    reflection: Array
    deviation: Array
    root: Array
    rate: float
    unit: str
    axes: tuple[str, ...]

    @classmethod
    def of(
        cls, surface: TextureMap, *, axis: str = "dft321", speeds: int = SPEEDS, forces: int = FORCES
    ) -> TextureTable:
        """Ask ``surface`` on a grid.

        Parameters
        ----------
        surface : TextureMap
        axis : str
            Of several axes one by name; ``"dft321"``: one axis with the power of all at every frequency (`summed`);
            ``"all"`` keeps them.
        speeds, forces : int
            Least numbers of nodes. The conditions of the surface's own models are always among them.

        Raises
        ------
        ParameterError
            If there is no such axis.
        """
        models = [_one_axis(model, axis) for model in surface.models]
        surface = TextureMap(models, surface.conditions, level=surface.level)
        grid_v = _grid(surface.conditions[:, 0], speeds)
        grid_f = _grid(surface.conditions[:, 1], forces)
        order = max(model.order for model in models)
        known_v, known_f = surface.known
        at = [
            [
                surface.at(float(v) if known_v else None, float(f) if known_f else None).of_order(order)
                for f in grid_f
            ]
            for v in grid_v
        ]
        first = models[0]
        return cls(
            grid_v,
            grid_f,
            np.array([[m.reflection for m in row] for row in at]),
            np.array([[0.5 * np.log(np.maximum(m.power, 1e-30)) for m in row] for row in at]),
            np.array([[_root(m.correlation) for m in row] for row in at]),
            first.rate,
            first.unit,
            first.axes,
        )

    def at(self, speed_mm_s: float, force_n: float) -> AutoregressiveModel:
        """Return the model that a block uses at a condition."""
        n, order = len(self.axes), self.reflection.shape[-1]
        reflection, deviation, root = np.empty((n, order)), np.empty(n), np.empty((n, n))
        _between(
            speed_mm_s,
            force_n,
            self.speeds,
            self.forces,
            self.reflection,
            self.deviation,
            self.root,
            reflection,
            deviation,
            root,
        )
        innovation = deviation * np.sqrt(np.prod((1 - reflection) * (1 + reflection), axis=1))
        return AutoregressiveModel(reflection, np.diag(innovation**2), self.rate, self.unit, self.axes)

    def error_db(self, surface: TextureMap, *, points: int, seed: int) -> float:
        """Return how far the table is from ``surface`` between its nodes, dB.

        The root mean square over frequency of the difference of the two power spectra in dB (the log-spectral
        distance), averaged over ``points`` random conditions within the grid. For a surface of one axis.
        """
        random = np.random.default_rng(seed)
        frequency = np.linspace(0.02, 0.98, 200) * self.rate / 2
        found = []
        for _ in range(points):
            v = float(random.uniform(self.speeds[0], self.speeds[-1]))
            f = float(random.uniform(self.forces[0], self.forces[-1]))
            asked = surface.at(
                *(x if known else None for x, known in zip((v, f), surface.known, strict=True))
            )
            ratio = self.at(v, f).power_spectrum(frequency) / asked.power_spectrum(frequency)
            found.append(np.sqrt(np.mean((10 * np.log10(ratio)) ** 2)))
        return float(np.mean(found))


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


def summed(model: AutoregressiveModel) -> AutoregressiveModel:
    """Return one axis that has the power of all axes of ``model`` at every frequency, as DFT321 has of a recording.

    The sum of all-pole spectra is not all-pole; the model that fits its autocorrelation up to a higher order stands in
    (twice as many coefficients and 8, at most 100).
    """
    if len(model.axes) == 1:
        return model
    grid = 8192
    density = model.power_spectrum(np.linspace(0, model.rate / 2, grid + 1)).sum(axis=0)
    order = min(2 * model.order + 8, max(100, model.order))
    correlation = np.fft.irfft(density)[: order + 1]
    correlation[0] *= 1 + 1e-9
    coefficients = np.concatenate(([1.0], solve_toeplitz(correlation[:-1], -correlation[1:])))
    reflection = reflection_of_polynomial(coefficients)
    power = float(model.power.sum())
    innovation = np.array([[power * np.prod((1 - reflection) * (1 + reflection))]])
    return AutoregressiveModel(reflection[None], innovation, model.rate, model.unit, ("dft321",))


def _one_axis(model: AutoregressiveModel, axis: str) -> AutoregressiveModel:
    if axis == "all":
        return model
    if axis == "dft321":
        return summed(model)
    if axis not in model.axes:
        raise ParameterError(f"axis must be dft321, all or one of {', '.join(model.axes)}, got {axis!r}")
    place = model.axes.index(axis)
    return replace(
        model,
        reflection=model.reflection[place : place + 1],
        innovation=model.innovation[place : place + 1, place : place + 1],
        mean=np.zeros(1),
        axes=(axis,),
    )


def _grid(values: Array, least: int) -> Array:
    """Return the values and evenly placed nodes between them, at least ``least``; one node where unknown."""
    if np.isnan(values).any():
        return np.zeros(1)
    nodes = np.unique(values)
    if len(nodes) == 1:
        return nodes
    widest = np.ptp(nodes) / (least - 1)
    parts = [
        np.linspace(a, b, max(1, int(np.ceil((b - a) / widest - 1e-9))), endpoint=False)
        for a, b in pairwise(nodes)
    ]
    if len(nodes) > 4 * least:  # a free-hand recording: nearly every sample is a condition of its own
        return np.linspace(nodes[0], nodes[-1], least)
    return np.concatenate([*parts, nodes[-1:]])


def _root(correlation: Array) -> Array:
    values, vectors = np.linalg.eigh(correlation)
    root: Array = (vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T
    return root


def _sinc(half: int, cutoff: float) -> Array:
    """Return a Kaiser-windowed sinc, shape (PHASES + 1, 2 half): row p is for a place p / PHASES past a sample."""
    at = np.arange(-half + 1, half + 1) - np.arange(PHASES + 1)[:, None] / PHASES
    inside = np.clip(1 - (at / half) ** 2, 0, None)
    kernel = cutoff * np.sinc(cutoff * at) * np.i0(6.0 * np.sqrt(inside)) / np.i0(6.0)
    return np.asarray(kernel / kernel.sum(axis=1, keepdims=True))


@numba.njit(cache=True, nogil=True)
def _node(value: float, nodes: Array) -> tuple[int, int, float]:
    last = len(nodes) - 1
    if last == 0 or not value > nodes[0]:
        return 0, 0, 0.0
    if value >= nodes[last]:
        return last, last, 0.0
    i = int(np.searchsorted(nodes, value, side="right")) - 1
    return i, i + 1, float((value - nodes[i]) / (nodes[i + 1] - nodes[i]))


@numba.njit(cache=True, nogil=True)
def _between(
    speed: float,
    force: float,
    speeds: Array,
    forces: Array,
    reflections: Array,
    deviations: Array,
    roots: Array,
    reflection: Array,  # (axis, order), written
    deviation: Array,  # (axis,), written, no logarithm
    root: Array,  # (axis, axis), written
) -> None:
    i0, i1, u = _node(speed, speeds)
    j0, j1, w = _node(force, forces)
    a, b, c, d = (1 - u) * (1 - w), u * (1 - w), (1 - u) * w, u * w
    axes, order = reflection.shape
    for n in range(axes):
        for m in range(order):
            reflection[n, m] = (
                a * reflections[i0, j0, n, m]
                + b * reflections[i1, j0, n, m]
                + c * reflections[i0, j1, n, m]
                + d * reflections[i1, j1, n, m]
            )
        deviation[n] = np.exp(
            a * deviations[i0, j0, n]
            + b * deviations[i1, j0, n]
            + c * deviations[i0, j1, n]
            + d * deviations[i1, j1, n]
        )
        for m in range(axes):
            root[n, m] = (
                a * roots[i0, j0, n, m]
                + b * roots[i1, j0, n, m]
                + c * roots[i0, j1, n, m]
                + d * roots[i1, j1, n, m]
            )


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
    _between(
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
