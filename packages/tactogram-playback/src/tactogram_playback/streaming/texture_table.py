"""Grid of a surface's models over speed and force, interpolated for every block.

`TextureMap` mixes models through their line spectral frequencies: accurate, but too slow for a block (1.4 ms per model
of order 40). So it is evaluated in advance on a grid, and the reflection coefficients of the four nearest nodes are
interpolated. This stays stable (a mean of numbers within (-1, 1) is within) and is exact at every node; in between the
error is below 0.05 dB on average over the spectrum.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple, TypeVar

import numba
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz

from tactogram.errors import ParameterError
from tactogram.signal import (
    AutoregressiveModel,
    ModelMap,
    TextureMap,
    reflection_of_polynomial,
    symmetric_root,
)

Array = NDArray[np.float64]
M = TypeVar("M")

SPEEDS = 17
"""Least number of nodes over speed, if known."""
FORCES = 9
"""Least number of nodes over force."""


class TextureGrid(NamedTuple):
    """Parameters of one surface's models on a grid over speed and force.

    Speeds (mm/s, shape (S,)) and forces (N, shape (F,)) ascend; a single node if the surface's models do not state
    them. Reflection coefficients have the shape (S, F, axis, order), ``deviation`` the natural logarithm of each
    axis's root mean square (S, F, axis), and ``root`` the square root of the innovations' correlation (S, F, axis,
    axis).
    """

    speeds: Array
    forces: Array
    reflection: Array
    deviation: Array
    root: Array


class TextureTable:
    """Models of one surface, sampled from a `TextureMap` on a grid over speed and force.

    Of several axes, ``axis`` selects one by name, ``"dft321"`` one with the power of all at every frequency
    (`summed`), and ``"all"`` all of them. ``speeds`` and ``forces`` are least numbers of nodes; the conditions of the
    surface's own models are always included. Raises `ParameterError` if there is no such axis.
    """

    def __init__(
        self, surface: TextureMap, *, axis: str = "dft321", speeds: int = SPEEDS, forces: int = FORCES
    ) -> None:
        models = [_one_axis(model, axis) for model in surface.models]
        surface = TextureMap(models, surface.conditions, level=surface.level)
        grid_v, grid_f, sampled = models_on_grid(surface, speeds, forces)
        order = max(model.order for model in models)
        grid = [[model.of_order(order) for model in row] for row in sampled]
        self.grid = TextureGrid(
            grid_v,
            grid_f,
            np.array([[m.reflection for m in row] for row in grid]),
            np.array([[0.5 * np.log(np.maximum(m.power, 1e-30)) for m in row] for row in grid]),
            np.array([[symmetric_root(m.correlation) for m in row] for row in grid]),
        )
        self.order = order
        self.rate, self.unit, self.axes = models[0].rate, models[0].unit, models[0].axes

    def at(self, speed_mm_s: float, force_n: float) -> AutoregressiveModel:
        """Return the model of a block at a condition."""
        n = len(self.axes)
        reflection, deviation, root = np.empty((n, self.order)), np.empty(n), np.empty((n, n))
        interpolate(speed_mm_s, force_n, self.grid, reflection, deviation, root)
        innovation = deviation * np.sqrt(np.prod((1 - reflection) * (1 + reflection), axis=1))
        return AutoregressiveModel(reflection, np.diag(innovation**2), self.rate, self.unit, self.axes)


def summed(model: AutoregressiveModel) -> AutoregressiveModel:
    """Return one axis that has the power of all axes of ``model`` at every frequency, as DFT321 has for a recording.

    The sum of all-pole spectra is not all-pole; it is approximated by the model that fits its autocorrelation up to a
    higher order (twice as many coefficients plus 8, at most 100).
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


def check_axis(axis: str, axes: tuple[str, ...]) -> None:
    """Refuse an ``axis`` that a table of models with ``axes`` cannot have."""
    if axis not in ("all", "dft321", *axes):
        raise ParameterError.must("axis", f"be dft321, all or one of {', '.join(axes)}", axis)


def models_on_grid(
    surface: ModelMap[M], speeds: int, forces: int, *, geometric: bool = False
) -> tuple[Array, Array, list[list[M]]]:
    """Return at least so many speeds (S,) and forces (F,) with those of the surface's models, and the models there.

    Speeds are evenly spaced, or their logarithms if ``geometric``.
    """
    grid_v = _grid(surface.conditions[:, 0], speeds, geometric=geometric)
    grid_f = _grid(surface.conditions[:, 1], forces)
    known_v, known_f = surface.has_conditions
    return (
        grid_v,
        grid_f,
        [
            [surface.at(float(v) if known_v else None, float(f) if known_f else None) for f in grid_f]
            for v in grid_v
        ],
    )


def _one_axis(model: AutoregressiveModel, axis: str) -> AutoregressiveModel:
    check_axis(axis, model.axes)
    if axis == "all":
        return model
    if axis == "dft321":
        return summed(model)
    index = model.axes.index(axis)
    return replace(
        model,
        reflection=model.reflection[index : index + 1],
        innovation=model.innovation[index : index + 1, index : index + 1],
        mean=np.zeros(1),
        axes=(axis,),
    )


def _grid(values: Array, least: int, *, geometric: bool = False) -> Array:
    """Return the values and nodes between them, at least ``least`` in all; a single node if unknown.

    They are evenly spaced, or their logarithms if ``geometric`` and no value is 0.
    """
    if np.isnan(values).any():
        return np.zeros(1)
    nodes = np.unique(values)
    if len(nodes) == 1:
        return nodes
    geometric = geometric and nodes[0] > 0
    spaced, scale = (np.geomspace, np.log(nodes)) if geometric else (np.linspace, nodes)
    if len(nodes) > 4 * least:  # a free-hand recording: nearly every sample is a separate condition
        return np.asarray(spaced(nodes[0], nodes[-1], least))
    widest = np.ptp(scale) / (least - 1)
    parts = np.maximum(1, np.ceil(np.diff(scale) / widest - 1e-9)).astype(int)
    between = [spaced(a, b, count + 1)[:-1] for (a, b), count in zip(pairwise(nodes), parts, strict=True)]
    return np.concatenate([*between, nodes[-1:]])


@numba.njit(cache=True, nogil=True)
def node(value: float, nodes: Array) -> tuple[int, int, float]:
    """Return the nodes on both sides of a value, and its relative position between them."""
    last = len(nodes) - 1
    if last == 0 or not value > nodes[0]:
        return 0, 0, 0.0
    if value >= nodes[last]:
        return last, last, 0.0
    i = 0
    while nodes[i + 1] <= value:
        i += 1
    return i, i + 1, float((value - nodes[i]) / (nodes[i + 1] - nodes[i]))


@numba.njit(cache=True, nogil=True)
def interpolate(
    speed: float,
    force: float,
    grid: TextureGrid,
    reflection: Array,  # (axis, order), written
    deviation: Array,  # (axis,), written, no logarithm
    root: Array,  # (axis, axis), written
) -> None:
    """Write the parameters at a condition, interpolated between the four nearest nodes; beyond the grid the nearest."""
    i0, i1, u = node(speed, grid.speeds)
    j0, j1, w = node(force, grid.forces)
    a, b, c, d = (1 - u) * (1 - w), u * (1 - w), (1 - u) * w, u * w
    r, s, q = grid.reflection, grid.deviation, grid.root
    axes, order = reflection.shape
    for x in range(axes):  # loops: numba takes seconds to compile expressions of arrays
        deviation[x] = np.exp(a * s[i0, j0, x] + b * s[i1, j0, x] + c * s[i0, j1, x] + d * s[i1, j1, x])
        for m in range(order):
            reflection[x, m] = (
                a * r[i0, j0, x, m] + b * r[i1, j0, x, m] + c * r[i0, j1, x, m] + d * r[i1, j1, x, m]
            )
        for y in range(axes):
            root[x, y] = a * q[i0, j0, x, y] + b * q[i1, j0, x, y] + c * q[i0, j1, x, y] + d * q[i1, j1, x, y]
