"""What filters cannot foresee of a signal: white noise, but for how it swells, clicks and repeats.

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

from tactogram.model import Example, SignalKind
from tactogram.models.stroke_gan.config import Config
from tactogram.signal import Signal
from tactogram.signal.autoregressive import AutoregressiveModel, mix
from tactogram.signal.autoregressive_fit import fit_autoregressive

Array = NDArray[np.float64]
MAX_ORDER = 60
"""As in `ar_texture`."""
REACH = 64
"""Samples to both sides that an axis is foreseen from the others by."""
PORTION = 1 << 14
"""Samples of a recording that are looked at together; bounds the memory."""


class Whitened:
    """What an autoregressive model of the material does not foresee, at unit variance, each axis by itself.

    An axis' model foresees it from its own past; what is left is foreseen, `REACH` samples to both sides, from
    what is left of the axes before it. So spectra, level and coherence between the axes are the filters', and the
    networks shape what those cannot say. Between materials the filters are mixed as `ar_texture`'s are, the ones
    between axes linearly.

    Attributes
    ----------
    couplings : list of float64 arrays, shape (axis, axis, 2 reach + 1)
        Per material; [i, j] foresees axis i from axis j < i.
    shares : list of float64 arrays, shape (axis,)
        Per material; the power that is left of each axis' error after that.
    """

    def __init__(self, config: Config, kind: SignalKind) -> None:
        self.config, self.kind = config, kind
        self.models: list[AutoregressiveModel] = []
        self.couplings: list[Array] = []
        self.shares: list[Array] = []
        self.reach = REACH if len(kind.axes) > 1 else 0

    @property
    def lead(self) -> int:
        """The highest order, and what the coupling reaches over at both ends."""
        return max((model.order for model in self.models), default=0) + 2 * self.reach

    @property
    def settle(self) -> int:
        """A whole length: the filters start at rest, and may ring for long."""
        return self.config.length

    def fit(self, examples: Sequence[Example]) -> dict[str, float]:
        """Fit a model and the couplings per material."""
        self.models, self.couplings, self.shares = [], [], []
        for name in self.kind.materials:
            signals = [example.signal for example in examples if example.material == name]
            most = min(MAX_ORDER, max(map(len, signals)) // 3)
            model = fit_autoregressive(signals, order=self.config.order, max_order=most)
            long = [signal.samples for signal in signals if len(signal) > model.order + 2 * self.reach]
            coupling, share = _couple([_error(model, x) for x in long], len(self.kind.axes), self.reach)
            self.models.append(model)
            self.couplings.append(coupling)
            self.shares.append(share)
        return {"order": float(np.mean([model.order for model in self.models]))}

    def inside(self, x: NDArray[np.float32], material: int) -> NDArray[np.float32]:
        """See `tactogram.models.stroke_gan.domain.Domain`."""
        model, coupling = self.models[material], self.couplings[material]
        error = _error(model, x[:, self.lead - 2 * self.reach - model.order :])
        left = error[:, self.reach : error.shape[1] - self.reach].copy()
        for i in range(1, len(error)):
            for j in range(i):
                left[i] -= np.convolve(error[j], coupling[i, j], "valid")
        return (left / np.sqrt(self.shares[material])[:, None]).astype(np.float32)

    def outside(self, y: NDArray[np.float32], weights: NDArray[np.float64]) -> Signal:
        """See `tactogram.models.stroke_gan.domain.Domain`."""
        model, parts = mix(self.models, weights), weights / weights.sum()
        coupling = np.tensordot(parts, np.array(self.couplings), 1)
        error = y * np.sqrt(np.tensordot(parts, np.array(self.shares), 1))[:, None]
        for i in range(1, len(error)):
            for j in range(i):
                error[i] += np.convolve(error[j], coupling[i, j], "same")
        error *= _unit(model)
        rows = zip(error, model.coefficients, strict=True)
        x = np.array([lfilter([1.0], taps, row) for row, taps in rows])
        x = x[:, self.settle - self.reach : x.shape[1] - self.reach] + np.asarray(model.mean)[:, None]
        return Signal(x.astype(np.float32), self.kind.rate, self.kind.unit, self.kind.axes)

    def state(self) -> dict[str, Any]:
        """Return the filters."""
        return {
            "models": [
                {"reflection": m.reflection, "innovation": m.innovation, "mean": m.mean} for m in self.models
            ],
            "couplings": self.couplings,
            "shares": self.shares,
        }

    def load_state(self, state: Mapping[str, Any]) -> None:
        """Go on from `state`."""
        self.models = [
            AutoregressiveModel(
                **{name: np.asarray(value, np.float64) for name, value in model.items()},
                rate=self.kind.rate,
                unit=self.kind.unit,
                axes=self.kind.axes,
            )
            for model in state["models"]
        ]
        self.couplings = [np.asarray(value, np.float64) for value in state["couplings"]]
        self.shares = [np.asarray(value, np.float64) for value in state["shares"]]


def _unit(model: AutoregressiveModel) -> Array:
    """Return the deviation of each axis' innovations, (axis, 1); 1 for a silent axis."""
    deviation = np.sqrt(model.variance)
    result: Array = np.where(deviation > 0, deviation, 1.0)[:, None]
    return result


def _error(model: AutoregressiveModel, x: NDArray[np.float32]) -> Array:
    """Return what the model does not foresee of (axis, time) samples, (axis, time - order), at unit variance."""
    deviation = x - np.asarray(model.mean)[:, None]
    rows = zip(deviation, model.coefficients, strict=True)
    return np.array([np.convolve(row, taps, "valid") for row, taps in rows]) / _unit(model)


def _couple(errors: Sequence[Array], axes: int, reach: int) -> tuple[Array, Array]:
    """Return the filters that foresee each axis from those before it by least squares, and the power left."""
    width = 2 * reach + 1
    coupling, share = np.zeros((axes, axes, width)), np.ones(axes)
    size = axes * (width + 1)
    gram = np.zeros((size, size))
    for error in errors:
        for start in range(0, error.shape[1] - width + 1, PORTION):
            part = error[:, start : start + PORTION + width - 1]
            windows = sliding_window_view(part, width, axis=1)  # A, T, W
            rows = np.hstack((*windows, windows[:, :, reach].T))  # T, A W + A
            gram += rows.T @ rows
    for i in range(1, axes):
        known, own = slice(0, i * width), axes * width + i
        power = gram[own, own]
        if not power > 0:
            continue
        # A little white noise on what is known keeps the equations well posed.
        inner = gram[known, known] + 1e-3 * power * np.eye(i * width)
        taps = np.linalg.solve(inner, gram[known, own])
        coupling[i, :i] = taps.reshape(i, width)[:, ::-1]
        left = power - 2 * taps @ gram[known, own] + taps @ gram[known, known] @ taps
        share[i] = max(left / power, 1e-6)
    return coupling, share
