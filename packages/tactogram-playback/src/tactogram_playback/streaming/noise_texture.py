"""Modulated noise that follows speed and force within a block.

`tactogram.signal.modulated_noise.mix` is evaluated in advance on a grid over speed and force, where it is stable and
exact. Between the nodes every parameter of the synthesis is interpolated as it is: gains and spectra hardly differ from
node to node, and a mean of the rotations that draw the gains makes no vector longer, so that any path over the grid is
stable (`tactogram.signal.modulated_noise_synthesis`). A mean of regression coefficients would not be.
"""

from __future__ import annotations

from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.rendering import MotionBlock, one_axis
from tactogram.signal import (
    ModulatedNoise,
    NoiseMap,
    NoiseProcess,
    parameters_of,
)
from tactogram_playback.streaming.texture_table import models_on_grid, node
from tactogram_playback.streaming.textures import Block, Resampler

Array = NDArray[np.float64]

SPEEDS, FORCES = 33, 3
"""Least number of nodes; a node has 2,800 numbers for one axis. Spectra move with the speed, not with the force."""


class NoiseGrid(NamedTuple):
    """Parameters of one surface's models on a grid over speed and force.

    Speeds (mm/s, shape (S,)) and forces (N, shape (F,)) as in `TextureGrid`; ``values`` are rows of `parameters_of`,
    float32, shape (S, F, parameter).
    """

    speeds: Array
    forces: Array
    values: NDArray[np.float32]


class NoiseTable:
    """Modulated noise of one surface, sampled from a `NoiseMap` on a grid over speed and force.

    ``axis``, ``speeds`` and ``forces`` are those of `TextureTable`; one axis of several is a model of its own
    (`one_axis`). Raises `ParameterError` if there is no such axis.
    """

    def __init__(
        self, surface: NoiseMap, *, axis: str = "dft321", speeds: int = SPEEDS, forces: int = FORCES
    ) -> None:
        self.surface = NoiseMap([one_axis(model, axis) for model in surface.models], surface.conditions)
        speed, force, models = models_on_grid(self.surface, speeds, forces, geometric=True)
        values = np.array([[parameters_of(model) for model in row] for row in models], np.float32)
        self.grid = NoiseGrid(speed, force, values)
        first = models[0][0]
        self.rate, self.unit, self.axes, self.lags = first.rate, first.unit, first.axes, first.lags

    def at(self, speed_mm_s: float, force_n: float) -> ModulatedNoise:
        """Return the model at a condition, which between the grid's nodes a block has nearly."""
        known_v, known_f = self.surface.has_conditions
        return self.surface.at(speed_mm_s if known_v else None, force_n if known_f else None)


class ModulatedNoiseTexture:
    """A `NoiseTable` as an endless signal at the engine's ``rate`` (Hz), in blocks of at most ``most`` samples.

    The mean of the models is omitted: it is gravity, or the sensor's.
    """

    holds_at_rest = False

    def __init__(self, name: str, table: NoiseTable, *, rate: float, most: int, seed: int) -> None:
        self.name, self.unit, self.axes, self.table = name, table.unit, table.axes, table
        self._process = NoiseProcess(len(table.axes), table.lags, table.rate, seed=seed)
        self._parameters = np.empty(table.grid.values.shape[2])
        speeds, forces, _ = table.grid
        middle = table.at(float(speeds[len(speeds) // 2]), float(forces[len(forces) // 2]))
        self.level = float(np.sqrt(np.sum(middle.power)))
        self.resampler = Resampler(len(table.axes), table.rate, rate=rate, most=most)
        self.delay_s = self.resampler.delay_s

    def render(self, motion: MotionBlock, out: Block) -> None:
        """Write the next ``motion.count`` samples to ``out``."""
        count = motion.count
        speed, force = motion.speed_mm_s[count - 1], motion.force_n[count - 1]
        _interpolate(speed, force, self.table.grid, self._parameters)
        new = self.resampler.room(count)
        self._process.next(new, self._parameters)
        self.resampler.write(new, count, out)


@numba.njit(cache=True, nogil=True)
def _interpolate(speed: float, force: float, grid: NoiseGrid, out: Array) -> None:
    """Write the mean of the four nearest nodes, shape (parameter,); beyond the grid the nearest."""
    i0, i1, u = node(speed, grid.speeds)
    j0, j1, w = node(force, grid.forces)
    a, b, c, d = (1 - u) * (1 - w), u * (1 - w), (1 - u) * w, u * w
    v = grid.values
    for p in range(len(out)):
        out[p] = a * v[i0, j0, p] + b * v[i1, j0, p] + c * v[i0, j1, p] + d * v[i1, j1, p]
