"""Whitening by autoregressive filters, and its inverse. Swells, clicks and periodic parts remain.

References
----------
- Atal, B. S. & Remde, J. R. (1982). A new model of LPC excitation for producing natural-sounding speech at low
  bit rates. Proc. ICASSP, 614-617.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.signal import lfilter

from tactogram.errors import ParameterError
from tactogram.model import Example, SignalKind
from tactogram.models.texture_gan.config import Config
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel, mix
from tactogram.signal.autoregressive_fit import fit_autoregressive

Array = NDArray[np.float64]
MAX_ORDER = 60
"""As in `ar_texture`."""
REACH = 64
"""Samples to both sides of the filters that predict an axis from the others."""
PORTION = 1 << 14
"""Samples of a recording processed at once; bounds the memory."""


class Whitening:
    """The prediction error of an autoregressive model of the material, each axis white and of unit variance.

    Each axis is predicted from its own past; its error is predicted, `REACH` samples to both sides, from the errors of
    the axes before it; and the rest again from its own past. The filters thus hold spectra, level and coherence between
    the axes, and the networks shape the rest. Filters of several materials are mixed as in `ar_texture`, those between
    axes linearly.

    Attributes
    ----------
    couplings : list of float64 arrays, shape (axis, axis, 2 reach + 1)
        Per material; [i, j] predicts axis i from axis j < i.
    rests : list of AutoregressiveModel
        Per material, of the rest of each axis's error, at unit variance.
    """

    def __init__(self, config: Config, kind: SignalKind) -> None:
        self.config, self.kind = config, kind
        self.models: list[AutoregressiveModel] = []
        self.couplings: list[Array] = []
        self.rests: list[AutoregressiveModel] = []
        self.reach = REACH if len(kind.axes) > 1 else 0

    @property
    def lead(self) -> int:
        """Samples before a crop that `whitened` needs: the highest orders and the reach of the coupling."""
        orders = [max((model.order for model in part), default=0) for part in (self.models, self.rests)]
        return sum(orders) + 2 * self.reach

    @property
    def settle(self) -> int:
        """Samples that `coloured` needs before those it returns: a whole length, since filters may ring for long."""
        return self.config.length

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Fit a model, the couplings and a model of the rest per material; return their mean order.

        Raises `ParameterError` if no recording of a material is long enough.
        """
        self.models, self.couplings, self.rests = [], [], []
        for name in self.kind.materials:
            signals = [example.signal for example in examples if example.material == name]
            most = min(MAX_ORDER, max(map(len, signals)) // 3)
            model = fit_autoregressive(signals, order=self.config.order, max_order=most)
            least = model.order + 4 * self.reach
            errors = [_error(model, signal.samples) for signal in signals if len(signal) > least]
            if not errors:
                raise ParameterError(
                    f"a recording of {name} must have more than {least} samples, got {max(map(len, signals))} at most"
                )
            coupling = _couple(errors, len(self.kind.axes), self.reach)
            rest = [signals[0].with_samples(self._rest(error, coupling)) for error in errors]
            order = self.config.order if self.reach else 0
            self.models.append(model)
            self.couplings.append(coupling)
            self.rests.append(fit_autoregressive(rest, order=order, max_order=most))
        return {"order": float(np.mean([model.order for model in self.models]))}

    def whitened(self, x: NDArray[np.float32], material: int) -> NDArray[np.float32]:
        """Return (axis, lead + time) samples of a recording as (axis, time) for the networks."""
        model, rest = self.models[material], self.rests[material]
        needed = model.order + rest.order + 2 * self.reach
        error = _error(model, x[:, self.lead - needed :])
        return _error(rest, self._rest(error, self.couplings[material])).astype(np.float32)

    def _rest(self, error: Array, coupling: Array) -> Array:
        """Return errors (axis, time) less their prediction from the axes before, (axis, time - 2 reach)."""
        rest = error[:, self.reach : error.shape[1] - self.reach].copy()
        for i in range(1, len(error)):
            for j in range(i):
                rest[i] -= np.convolve(error[j], coupling[i, j], "valid")
        return rest

    def coloured(self, y: NDArray[np.float32], weights: NDArray[np.float64]) -> Signal:
        """Return (axis, settle + time) samples of the networks as a signal; ``weights`` are by material."""
        model, rest = mix(self.models, weights), mix(self.rests, weights)
        coupling = np.tensordot(weights / weights.sum(), np.array(self.couplings), 1)
        error = _driven(rest, y)
        for i in range(1, len(error)):
            for j in range(i):
                error[i] += np.convolve(error[j], coupling[i, j], "same")
        x = _driven(model, error)
        x = x[:, self.settle - self.reach : x.shape[1] - self.reach]
        return self.kind.signal(x.astype(np.float32))

    def state(self) -> dict[str, Any]:
        return {
            "models": [_parts(model) for model in self.models],
            "couplings": self.couplings,
            "rests": [_parts(model) for model in self.rests],
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        self.models, self.rests = (
            [self._model(parts) for parts in state[name]] for name in ("models", "rests")
        )
        self.couplings = [np.asarray(value, np.float64) for value in state["couplings"]]

    def _model(self, parts: Mapping[str, Any]) -> AutoregressiveModel:
        arrays = {name: np.asarray(value, np.float64) for name, value in parts.items()}
        return AutoregressiveModel(**arrays, rate=self.kind.rate, unit=self.kind.unit, axes=self.kind.axes)


def _parts(model: AutoregressiveModel) -> dict[str, Any]:
    return {"reflection": model.reflection, "innovation": model.innovation, "mean": model.mean}


def _unit(model: AutoregressiveModel) -> Array:
    """Return the deviation of each axis's innovations, (axis, 1); 1 for a silent axis."""
    deviation = np.sqrt(model.variance)
    result: Array = np.where(deviation > 0, deviation, 1.0)[:, None]
    return result


def _error(model: AutoregressiveModel, x: NDArray[Any]) -> Array:
    """Return the prediction error of (axis, time) samples, (axis, time - order), at unit variance."""
    deviation = x - np.asarray(model.mean)[:, None]
    rows = zip(deviation, model.coefficients, strict=True)
    return np.array([np.convolve(row, taps, "valid") for row, taps in rows]) / _unit(model)


def _driven(model: AutoregressiveModel, error: NDArray[Any]) -> Array:
    """Return errors of unit variance, (axis, time), through the model's filters, which begin at rest."""
    rows = zip(error * _unit(model), model.coefficients, strict=True)
    driven: Array = np.array([lfilter([1.0], taps, row) for row, taps in rows])
    driven += np.asarray(model.mean)[:, None]
    return driven


def _couple(errors: Sequence[Array], axes: int, reach: int) -> Array:
    """Return the filters that predict each axis from those before it, by least squares."""
    width = 2 * reach + 1
    coupling = np.zeros((axes, axes, width))
    if axes == 1:
        return coupling
    size = axes * (width + 1)
    gram = np.zeros((size, size))
    for error in errors:
        for start in range(0, error.shape[1] - width + 1, PORTION):
            part = error[:, start : start + PORTION + width - 1]
            windows = sliding_window_view(part, width, axis=1)  # A, T, W
            rows = np.hstack((*windows, windows[:, :, reach].T))  # T, A W + A
            gram += rows.T @ rows
    for i in range(1, axes):
        before, axis = slice(0, i * width), axes * width + i
        power = gram[axis, axis]
        if not power > 0:
            continue
        # A little white noise keeps the equations well posed.
        inner = gram[before, before] + 1e-3 * power * np.eye(i * width)
        taps = np.linalg.solve(inner, gram[before, axis])
        coupling[i, :i] = taps.reshape(i, width)[:, ::-1]
    return coupling
