"""Fitting of autoregressive models to recordings: Burg's method over pieces, Yule-Walker, the order by AIC.

References
----------
- Burg, J. P. (1975). Maximum Entropy Spectral Analysis. PhD thesis, Stanford University.
- de Waele, S. & Broersen, P. M. T. (2000). The Burg algorithm for segments. IEEE Trans. Signal Process. 48(10),
  2876-2880. doi 10.1109/78.869039
- Kay, S. M. (1988). Modern Spectral Estimation: Theory and Application. Prentice Hall. Ch. 6 and 7.
- Akaike, H. (1974). A new look at the statistical model identification. IEEE Trans. Autom. Control 19(6), 716-723. doi
  10.1109/TAC.1974.1100705
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.signal.autoregressive import AutoregressiveModel
from tactogram.signal.signal import Signal

Array = NDArray[np.float64]
Method = Literal["burg", "yule-walker"]


def fit_autoregressive(
    signals: Signal | Sequence[Signal],
    *,
    order: int | None = None,
    max_order: int | None = None,
    method: Method = "burg",
) -> AutoregressiveModel:
    """Fit one model to one signal, or to several pieces of one process.

    Pieces are never joined: Burg's error sums (de Waele & Broersen 2000), or the autocorrelation, run over all of them.
    The model's power is the mean square of the data about its mean, exactly.

    Parameters
    ----------
    signals : Signal or sequence of Signal
        Over time; equal in rate, unit and axes; their lengths may differ.
    order : int, optional
        None is the order with the least AIC (Akaike 1974), one for all axes.
    max_order : int, optional
        Highest order for AIC; by default 60, or a third of the longest piece if that is less.
    method : {"burg", "yule-walker"}
        Kay 1988, Ch. 7; Yule-Walker with the biased autocorrelation. Both always give a stable model.
    """
    pieces = [signals] if isinstance(signals, Signal) else list(signals)
    if not pieces:
        raise ParameterError("at least one signal is needed to fit a model, got none")
    kind = pieces[0]
    for piece in pieces:
        if piece.domain != "time":
            raise ParameterError(
                "an autoregressive model is fitted to signals over time, got one over displacement"
            )
        if (piece.rate, piece.unit, piece.axes) != (kind.rate, kind.unit, kind.axes):
            raise ParameterError("signals to fit one model to must be equal in rate, unit and axes")
    longest = max(map(len, pieces))
    highest = order if order is not None else max_order if max_order is not None else min(60, longest // 3)
    if not 0 <= highest < longest:
        raise ParameterError.must("order", f"be >= 0 and less than the {longest} samples at hand", highest)
    if method not in ("burg", "yule-walker"):
        raise ParameterError.must("method", "be 'burg' or 'yule-walker'", method)

    arrays = [piece.samples.astype(np.float64) for piece in pieces]
    count = sum(map(len, pieces))
    mean: Array = sum(a.sum(axis=1) for a in arrays) / count
    arrays = [a - mean[:, None] for a in arrays]
    power: Array = sum(np.square(a).sum(axis=1) for a in arrays) / count
    reflection = (_burg if method == "burg" else _yule_walker)(arrays, highest)
    if order is None:
        reflection = reflection[:, : _least_aic(reflection, power, count)]
    error = power * np.prod((1 - reflection) * (1 + reflection), axis=1)
    model = AutoregressiveModel(reflection, np.diag(error), kind.rate, kind.unit, kind.axes, mean)
    return model if len(kind.axes) == 1 else _with_correlation(model, pieces)


def reflection_of_autocorrelation(autocorrelation: ArrayLike) -> Array:
    """Return the reflection coefficients, shape (lag - 1,), of an autocorrelation, shape (lag,).

    Levinson-Durbin (Kay 1988, Ch. 6). The autoregressive process has exactly this autocorrelation at these lags.
    """
    r = np.asarray(autocorrelation, np.float64)
    reflection = np.zeros(r.size - 1)
    polynomial, error = np.ones(1), r[0]
    for m in range(reflection.size):
        k = _bounded(-polynomial @ r[m + 1 : 0 : -1], error)
        reflection[m] = k
        padded = np.append(polynomial, 0.0)
        polynomial = padded + k * padded[::-1]
        error *= (1 - k) * (1 + k)
    return reflection


def _burg(pieces: list[Array], order: int) -> Array:
    """Return reflection coefficients (axis, order) by Burg's method, its sums over all pieces."""
    reflection = np.zeros((len(pieces[0]), order))
    errors = [(piece, piece) for piece in pieces]
    for m in range(order):
        errors = [(f[:, 1:], b[:, :-1]) for f, b in errors if f.shape[1] > 1]
        cross = sum(np.einsum("at,at->a", f, b) for f, b in errors)
        energy = sum(np.einsum("at,at->a", f, f) + np.einsum("at,at->a", b, b) for f, b in errors)
        reflection[:, m] = _bounded(-2 * np.asarray(cross), np.asarray(energy))
        k = reflection[:, m, None]
        errors = [(f + k * b, b + k * f) for f, b in errors]
    return reflection


def _yule_walker(pieces: list[Array], order: int) -> Array:
    """Return reflection coefficients (axis, order) of the pooled biased autocorrelation."""
    size = 2 ** int(np.ceil(np.log2(max(p.shape[1] for p in pieces) + order + 1)))
    spectrum = sum(np.abs(np.fft.rfft(p, size)) ** 2 for p in pieces)
    r = np.fft.irfft(spectrum, size)[:, : order + 1]
    return np.array([reflection_of_autocorrelation(row) for row in r]).reshape(len(r), order)


def _bounded(numerator: Array, denominator: Array) -> Array:
    """Return the quotient, 0 where there is no energy left, and below 1 despite rounding."""
    safe = np.where(denominator > 0, denominator, 1.0)
    quotient: Array = np.clip(np.where(denominator > 0, numerator / safe, 0.0), -1 + 1e-12, 1 - 1e-12)
    return quotient


def _least_aic(reflection: Array, power: Array, count: int) -> int:
    """Return the order with the least AIC, summed over the axes (Akaike 1974)."""
    heard = power > 0
    if not heard.any():
        return 0
    steps = np.log((1 - reflection[heard]) * (1 + reflection[heard])).sum(axis=0)
    criterion = count * np.concatenate(([0.0], np.cumsum(steps)))
    criterion += 2 * heard.sum() * np.arange(criterion.size)
    return int(np.argmin(criterion))


def _with_correlation(model: AutoregressiveModel, pieces: Sequence[Signal]) -> AutoregressiveModel:
    """Return ``model`` with the correlation of the prediction errors over the axes."""
    together = np.zeros_like(model.innovation)
    for piece in pieces:
        if len(piece) > model.order:
            error = model.prediction_error(piece)
            together += error @ error.T
    deviation = np.sqrt(model.variance)
    correlation = replace(model, innovation=together).correlation
    return replace(model, innovation=correlation * np.outer(deviation, deviation))
