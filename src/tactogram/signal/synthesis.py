"""Synthesis of autoregressive textures: endless, block by block, without seams, while the model changes.

The filter is the normalised ladder of Gray & Markel (1975): a rotation per reflection coefficient. Driven by white
noise of variance 1 every number in it has variance 1, whatever the coefficients are and however fast they change, since
a rotation preserves it. So a signal starts in its stationary state, has the right level from its first sample, and
keeps it while one texture turns into another; and an order of 60 is as exact as an order of 2.

References
----------
- Gray, A. H. & Markel, J. D. (1975). A normalized digital filter structure. IEEE Trans. Acoust., Speech, Signal
  Process. 23(3), 268-277. doi 10.1109/TASSP.1975.1162680
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.autoregressive import AutoregressiveModel, mix, symmetric_root
from tactogram.signal.signal import Signal

Array = NDArray[np.float64]

WAYPOINTS = 4
"""Steps of a transition for which models are mixed through line spectral frequencies."""


class Synthesizer:
    """An endless signal of a texture; n samples in blocks are the n samples of one call, bit for bit.

    Parameters
    ----------
    model : AutoregressiveModel
    seed : int or numpy.random.Generator
        Determines the noise, and with the models and the times of change, every sample.
    glide_s : float
        Duration of a transition, s. 0 changes the model from one sample to the next.
    """

    def __init__(
        self, model: AutoregressiveModel, *, seed: int | np.random.Generator, glide_s: float = 0.02
    ) -> None:
        if not (glide_s >= 0 and np.isfinite(glide_s)):
            raise ParameterError.must("glide_s", "be >= 0 s", glide_s)
        self._random = np.random.default_rng(seed)
        self._glide = max(1, round(glide_s * model.rate))
        self._done = self._glide
        self._way = [model] * (WAYPOINTS + 1)
        self._state = self._draw(model, model.order)
        self._load()

    @property
    def model(self) -> AutoregressiveModel:
        """The current model, or the target of the transition."""
        return self._way[-1]

    def next(self, samples: int, model: AutoregressiveModel | None = None) -> Signal:
        """Return the next ``samples`` of the signal, with a transition to ``model`` from the first of them on.

        A `ParameterError` if ``samples`` is less than 1, or ``model`` has another rate, unit or set of axes.
        """
        if samples < 1:
            raise ParameterError.must("samples", "be >= 1", samples)
        if model is not None and model is not self.model:
            self._turn_to(model)
        noise = self._random.standard_normal((samples, len(self.model.axes)))
        out = np.empty((len(self.model.axes), samples))
        ladder(noise, self._state, *self._parameters, self._done, self._glide, out)
        self._done = min(self._glide, self._done + samples)
        return Signal(out.astype(np.float32), self.model.rate, self.model.unit, self.model.axes)

    def _turn_to(self, model: AutoregressiveModel) -> None:
        waypoint = self._done / self._glide * WAYPOINTS
        step = min(int(waypoint), WAYPOINTS - 1)
        share = waypoint - step
        here = mix(self._way[step : step + 2], [1 - share, share])
        self._way = [mix([here, model], [1 - w, w]) for w in np.linspace(0, 1, WAYPOINTS + 1)]
        more = max(here.order, model.order) - self._state.shape[1]
        if more > 0:
            self._state = np.hstack((self._state, self._draw(here, more)))
        self._done = 0
        self._load()

    def _draw(self, model: AutoregressiveModel, count: int) -> Array:
        """Draw ladder states: white, variance 1, the axes correlated as the innovations are."""
        return symmetric_root(model.correlation) @ self._random.standard_normal((len(model.axes), count))

    def _load(self) -> None:
        order = self._state.shape[1]
        way = [m.of_order(order) for m in self._way]
        self._parameters = (
            np.array([m.reflection for m in way]),
            np.array([np.sqrt(m.power) for m in way]),
            np.array([m.mean for m in way]),
            np.array([symmetric_root(m.correlation) for m in way]),
        )


def synthesise(model: AutoregressiveModel, seconds: float, *, seed: int | np.random.Generator) -> Signal:
    """Return ``seconds`` (at least one sample) of a texture."""
    if not (seconds > 0 and np.isfinite(seconds)):
        raise ParameterError.must("seconds", "be > 0", seconds)
    return Synthesizer(model, seed=seed).next(max(1, round(seconds * model.rate)))


@numba.njit(cache=True)
def ladder(
    noise: Array,  # (time, axis)
    state: Array,  # (axis, order), changed in place
    reflection: Array,  # (waypoint, axis, order)
    deviation: Array,  # (waypoint, axis)
    mean: Array,  # (waypoint, axis)
    root: Array,  # (waypoint, axis, axis)
    done: int,
    glide: int,
    out: Array,  # (axis, time), written
) -> None:
    """Write the output of the ladder for noise of variance 1, with parameters between their waypoints."""
    last = len(reflection) - 1
    axes, order = state.shape
    for t in range(len(noise)):
        waypoint = min(1.0, (done + t) / glide) * last
        i = min(int(waypoint), last - 1)
        r = waypoint - i
        for a in range(axes):
            x = 0.0
            square = 0.0
            for b in range(axes):
                share = (1 - r) * root[i, a, b] + r * root[i + 1, a, b]
                x += share * noise[t, b]
                square += share * share
            x /= np.sqrt(square)
            for m in range(order - 1, -1, -1):
                k = (1 - r) * reflection[i, a, m] + r * reflection[i + 1, a, m]
                c = np.sqrt((1 - k) * (1 + k))
                b0 = state[a, m]
                if m + 1 < order:
                    state[a, m + 1] = k * x + c * b0
                x = c * x - k * b0
            if order:
                state[a, 0] = x
            level = (1 - r) * deviation[i, a] + r * deviation[i + 1, a]
            out[a, t] = level * x + (1 - r) * mean[i, a] + r * mean[i + 1, a]
