"""Autoregressive textures: noise through an all-pole filter.

Each axis is ``x[n] = -a_1 x[n-1] - … - a_p x[n-p] + e[n]``, its innovations e white with one covariance over the axes.
Models are fitted in `tactogram.signal.autoregressive_fit`, mixed here through their line spectral frequencies
(`tactogram.signal.line_spectrum`), synthesised in `tactogram.signal.synthesis`, and interpolated over speed and force
in `tactogram.signal.texture_map`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.signal.line_spectrum import (
    line_spectrum_of_reflection,
    polynomial_of_reflection,
    reflection_of_line_spectrum,
    reflection_of_polynomial,
)
from tactogram.signal.signal import Signal, check_rate

Array = NDArray[np.float64]
Level = Literal["log", "linear"]

SILENCE = 1e-6
"""Power of a silent model in a mix, as a share of the loudest one's: 60 dB below it."""


@dataclass(frozen=True, eq=False)
class AutoregressiveModel:
    """One texture: an all-pole filter per axis, and the innovations that drive them.

    Parameters
    ----------
    reflection : float64 array, shape (axis, order)
        Reflection coefficients, within (-1, 1), so that every model is stable.
    innovation : float64 array, shape (axis, axis)
        Covariance of the innovations, unit^2.
    rate : float, Hz
    unit : str
    axes : tuple of str
    mean : float64 array, shape (axis,), optional
        In ``unit``; 0 by default.
    """

    reflection: Array
    innovation: Array
    rate: float
    unit: str
    axes: tuple[str, ...]
    mean: Array | None = None

    def __post_init__(self) -> None:
        n = len(self.axes)
        reflection = _fixed(self.reflection)
        innovation = _fixed(self.innovation)
        mean = _fixed(np.zeros(n) if self.mean is None else self.mean)
        if n == 0 or reflection.ndim != 2 or len(reflection) != n:
            raise ParameterError.must("reflection", f"be ({n} axes, order), got shape {reflection.shape}")
        if not np.all(np.abs(reflection) < 1):
            raise ParameterError(
                "reflection coefficients must be within (-1, 1): the filter would not be stable"
            )
        if innovation.shape != (n, n) or mean.shape != (n,):
            raise ParameterError.must(
                "innovation", f"be ({n}, {n}) and mean ({n},), got {innovation.shape} and {mean.shape}"
            )
        if not (np.isfinite(innovation).all() and np.isfinite(mean).all()):
            raise ParameterError("innovation and mean must be finite")
        if not np.allclose(innovation, innovation.T) or _lowest(innovation) < -1e-9:
            raise ParameterError.must("innovation", "be a covariance: symmetric, no negative eigenvalue")
        check_rate(self.rate)
        object.__setattr__(self, "reflection", reflection)
        object.__setattr__(self, "innovation", innovation)
        object.__setattr__(self, "mean", mean)
        object.__setattr__(self, "axes", tuple(self.axes))

    @classmethod
    def from_coefficients(
        cls,
        coefficients: ArrayLike,
        innovation: ArrayLike,
        *,
        rate: float,
        unit: str,
        axes: Sequence[str] = ("z",),
        mean: ArrayLike | None = None,
    ) -> AutoregressiveModel:
        """Return the model of given polynomials.

        Parameters
        ----------
        coefficients : float array, shape (axis, order + 1)
            Each row begins with 1.
        innovation : float array, shape (axis, axis) or (axis,), unit^2
            Covariance, or variances.
        rate : float, Hz
        unit, axes
            Of the synthesised signals.
        mean : float array, shape (axis,), unit, optional
        """
        rows = [reflection_of_polynomial(row) for row in np.atleast_2d(np.asarray(coefficients, np.float64))]
        covariance = np.asarray(innovation, np.float64)
        if covariance.ndim < 2:
            covariance = np.diag(np.atleast_1d(covariance))
        means = None if mean is None else np.asarray(mean, np.float64)
        return cls(np.array(rows), covariance, rate, unit, tuple(axes), means)

    @property
    def order(self) -> int:
        """Order of the filters."""
        return int(self.reflection.shape[1])

    @property
    def coefficients(self) -> Array:
        """Polynomials A(z), float64, shape (axis, order + 1), each beginning with 1."""
        return np.array([polynomial_of_reflection(row) for row in self.reflection])

    @cached_property
    def line_spectrum(self) -> Array:
        """Line spectral frequencies, rad/sample, float64, shape (axis, order), ascending."""
        return np.array([line_spectrum_of_reflection(row) for row in self.reflection])

    @property
    def variance(self) -> Array:
        """Variance of the innovations, unit^2, float64, shape (axis,)."""
        return np.diag(self.innovation).copy()

    @property
    def correlation(self) -> Array:
        """Correlation of the innovations, float64, shape (axis, axis); a silent axis has none with others."""
        return _correlation(self.innovation)

    @property
    def gain(self) -> Array:
        """Power of each axis over that of its innovations, float64, shape (axis,), >= 1."""
        result: Array = 1.0 / np.prod((1 - self.reflection) * (1 + self.reflection), axis=1)
        return result

    @property
    def power(self) -> Array:
        """Variance of each axis, unit^2, float64, shape (axis,)."""
        return self.variance * self.gain

    def power_spectrum(self, frequencies: ArrayLike) -> Array:
        """Return the one-sided power spectral density, unit^2/Hz, float64, shape (axis, frequency).

        Its integral from 0 to rate / 2, the range of ``frequencies`` (Hz, else `ParameterError`), is `power`.
        """
        f = np.atleast_1d(np.asarray(frequencies, np.float64))
        if f.ndim != 1 or not np.all((f >= 0) & (f <= self.rate / 2)):
            raise ParameterError.must("frequencies", f"be one row within 0 to {self.rate / 2:g} Hz")
        z = np.exp(-2j * np.pi * f / self.rate)
        forward = np.ones((len(self.axes), f.size), complex)
        backward = forward
        for k in self.reflection.T[:, :, None]:
            forward, backward = forward + k * z * backward, z * backward + k * forward
        density: Array = 2 * self.variance[:, None] / (self.rate * np.abs(forward) ** 2)
        return density

    def of_order(self, order: int) -> AutoregressiveModel:
        """Return the same process with a higher order (added coefficients are 0); `ParameterError` for a lower one."""
        if order < self.order:
            raise ParameterError.must("order", f"be >= {self.order}", order)
        if order == self.order:
            return self
        return replace(self, reflection=np.pad(self.reflection, ((0, 0), (0, order - self.order))))

    def prediction_error(self, signal: Signal) -> Array:
        """Return the innovations of ``signal``, float64, shape (axis, time - order), in its unit.

        Raises `ParameterError` if the signal is of another rate, unit or set of axes, or not longer than the order.
        """
        _same(self, signal)
        if len(signal) <= self.order:
            raise ParameterError.must(
                "signal", f"be longer than the order {self.order}, got {len(signal)} samples"
            )
        forward = backward = signal.samples.astype(np.float64) - np.asarray(self.mean)[:, None]
        for k in self.reflection.T[:, :, None]:
            forward, backward = (
                forward[:, 1:] + k * backward[:, :-1],
                backward[:, :-1] + k * forward[:, 1:],
            )
        return np.asarray(forward)


def mix(
    models: Sequence[AutoregressiveModel], weights: ArrayLike, *, level: Level = "log"
) -> AutoregressiveModel:
    """Return the model between ``models``: line spectral frequencies averaged by weight, and always stable.

    The output power, not the variance of the innovations, is interpolated: in dB (``level="log"``), which is perceived
    as even, or linearly. A silent axis has no spectrum to add; its level counts as `SILENCE`.

    Raises `ParameterError` if the models differ in kind or the weights are invalid.

    Parameters
    ----------
    models : sequence of AutoregressiveModel
        Equal in rate, unit and axes; the order may differ.
    weights : array-like, shape (model,)
        >= 0, not all 0; scaled to sum to 1.
    """
    w = checked_weights(weights, len(models))
    for model in models:
        _same(models[0], model)
    chosen = [m for m, share in zip(models, w, strict=True) if share > 0]
    w = w[w > 0] / w.sum()
    if len(chosen) == 1:
        return chosen[0]
    order = max(m.order for m in chosen)
    powers = np.array([m.power for m in chosen])
    lines = np.array([m.of_order(order).line_spectrum for m in chosen])
    shares = w[:, None] * (powers > 0)
    shares = np.where(shares.any(axis=0), shares, w[:, None])
    mean_lines = np.einsum("ma,mal->al", shares / shares.sum(axis=0), lines)
    reflection = np.array([reflection_of_line_spectrum(row) for row in mean_lines])
    if level == "linear":
        power = w @ powers
    else:
        loudest = powers.max(axis=0)
        heard = np.where(powers > 0, powers, SILENCE * loudest)
        power = np.exp(w @ np.log(np.where(loudest > 0, heard, 1.0))) * (loudest > 0)
    deviation = np.sqrt(power * np.prod((1 - reflection) * (1 + reflection), axis=1))
    correlation = np.tensordot(w, [m.correlation for m in chosen], axes=1)
    mixed = replace(
        chosen[0],
        reflection=reflection,
        innovation=correlation * np.outer(deviation, deviation),
        mean=w @ np.array([m.mean for m in chosen]),
    )
    mixed.__dict__["line_spectrum"] = mean_lines  # cached: a stream mixes mixes, block by block
    return mixed


def _correlation(covariance: Array) -> Array:
    deviation = np.sqrt(np.diag(covariance))
    safe = np.where(deviation > 0, deviation, 1.0)
    correlation: Array = covariance / np.outer(safe, safe)
    np.fill_diagonal(correlation, 1.0)
    return correlation


def _lowest(covariance: Array) -> float:
    return (
        float(np.linalg.eigvalsh(_correlation(covariance))[0]) if (np.diag(covariance) >= 0).all() else -1.0
    )


def _fixed(values: ArrayLike) -> Array:
    array = np.array(values, np.float64)
    array.flags.writeable = False
    return array


def _same(model: AutoregressiveModel, other: AutoregressiveModel | Signal) -> None:
    if (model.rate, model.unit, model.axes) != (other.rate, other.unit, other.axes):
        raise ParameterError(
            f"expected {model.rate:g} Hz, {model.unit}, axes {','.join(model.axes)}; "
            f"got {other.rate:g} Hz, {other.unit}, axes {','.join(other.axes)}"
        )


def checked_weights(weights: ArrayLike, count: int) -> Array:
    """Return weights, float64, shape (``count``,), of at least 1; `ParameterError` if one is negative or all are 0."""
    w = np.asarray(weights, np.float64)
    if not count or w.shape != (count,) or not (np.isfinite(w).all() and (w >= 0).all() and w.any()):
        raise ParameterError.must("weights", f"be {count} numbers >= 0, not all 0; got {w.tolist()}")
    return w


def symmetric_root(covariance: Array) -> Array:
    """Return the symmetric square root, which also exists for a singular matrix and changes smoothly."""
    values, vectors = np.linalg.eigh(covariance)
    root: Array = (vectors * np.sqrt(np.maximum(values, 0))) @ vectors.T
    return root
