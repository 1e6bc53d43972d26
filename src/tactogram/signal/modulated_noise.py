"""Modulated noise: a texture as band noise whose strength fluctuates as recorded.

Per axis, white noise is split into `BANDS` bands, each with a gain that changes every `FRAME_S`. Their sum is divided
by its own short-time level and multiplied by the wanted one, `SUBFRAMES` times per frame; a minimum-phase filter gives
the result the recorded spectrum. What is not streamed also gets the clicks of recordings
(`tactogram.signal.local_amplitudes`). The logarithms of all gains are a vector autoregression, transformed value by
value to their recorded distributions, plus an offset that is drawn once per signal, as recordings differ. The spectral
lines of ribs and weaves, which are not noise, are added (`tactogram.signal.tones`).

All parameters are means, covariances, quantiles and logarithms, so that a weighted mean of two models is a model:
distributions are mixed as Wasserstein barycentres, and the autoregression follows from mixed covariances, hence is
always stable. It is drawn by a normalised lattice, the counterpart of the ladder in `tactogram.signal.synthesis`: one
rotation per lag, so that its scores keep their variance while a texture changes. Models are fitted in
`tactogram.signal.modulated_noise_fit` and synthesised in `tactogram.signal.modulated_noise_synthesis`.

References
----------
- Biller, B. & Nelson, B. L. (2003). Modeling and generating multivariate time-series input processes using a vector
  autoregressive technique. ACM Trans. Model. Comput. Simul. 13(3), 211-237. doi 10.1145/937332.937333 (normal scores of
  a vector autoregression, transformed to any marginal distributions)
- Morf, M., Vieira, A. & Kailath, T. (1978). Covariance characterization by partial autocorrelation matrices. Ann.
  Statist. 6(3), 643-648 (the normalised reflection coefficients of several channels)
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from tactogram.errors import ParameterError
from tactogram.signal.autoregressive import checked_weights, symmetric_root
from tactogram.signal.filters import minimum_phase
from tactogram.signal.local_amplitudes import LEVELS as LOCAL_LEVELS, WINDOWS_S
from tactogram.signal.tones import Tones, mix_tones

Array = NDArray[np.float64]

BANDS = 4
FRAME_S = 0.01
"""Duration of a frame; the gains of the bands are given at its end."""
SUBFRAMES = 4
"""Values of the short-time level per frame."""
LEVEL_S = 0.0008
"""Time constant of the short-time level, s, but at least two samples."""
LOWEST_HZ, HIGHEST_HZ = 18.0, 1100.0
"""Range of the bands; the highest is at most 0.46 of the rate."""
LEAST_RATE = 800.0
"""Two samples per subframe, Hz."""
LEVELS = np.concatenate(
    ([0.0005, 0.002, 0.005, 0.01, 0.02], np.linspace(0.05, 0.95, 19), [0.98, 0.99, 0.995, 0.998, 0.9995])
)
"""Quantiles that represent a distribution."""
SCORES = scipy.special.ndtri(LEVELS)
"""Their normal scores."""
RIDGE = 1e-3
"""Added to the variance of every normal score, 1: nearly constant gains have a singular covariance."""
TAPS = 512
"""Of the minimum-phase filter."""
INNER = np.array([1.5, 0.86])
"""Edges, as shares of the lowest and the highest of the bands, within which a spectrum may be moved."""


@dataclass(frozen=True, eq=False)
class ModulatedNoise:
    """One texture: noise and tones. The gains of a frame are, per axis, those of the bands, then of the subframes.

    Parameters
    ----------
    quantiles : float64 array, shape (gain, quantile)
        Natural logarithms of amplitudes at `LEVELS`, ascending along the last.
    covariance : float64 array, shape (lag + 1, gain, gain)
        E z[t] z[t - lag]^T of the normal scores z of the gains, each recording's mean removed.
    offsets : float64 array, shape (gain, gain)
        Covariance of the recordings' means.
    deviation : float64 array, shape (axis,)
        Natural logarithm of the standard deviation of each axis's noise.
    correlation : float64 array, shape (axis, axis)
        Of the axes. The gains are those of sources without it, one per axis.
    coupling : float64 array, shape (band, axis, axis)
        Correlation of the sources' noise that is left in each band.
    equaliser : float64 array, shape (axis, frequency)
        Natural logarithm of the filter's magnitude, from 0 to half the rate.
    spectrum : float64 array, shape (axis, frequency)
        Natural logarithm of the amplitude spectrum of the recorded noise, which decides the level of a mix.
    mean : float64 array, shape (axis,)
        In ``unit``: gravity, or a sensor's offset.
    rate : float, Hz
    unit : str
    axes : tuple of str
    tones : Tones
    local : float64 array, shape (axis, window, quantile)
        Of `tactogram.signal.local_amplitudes`; without an axis where it is unknown, as in runs of 0.1.0.
    """

    quantiles: Array
    covariance: Array
    offsets: Array
    deviation: Array
    correlation: Array
    coupling: Array
    equaliser: Array
    spectrum: Array
    mean: Array
    rate: float
    unit: str
    axes: tuple[str, ...]
    tones: Tones
    local: Array = field(default_factory=lambda: np.empty((0, len(WINDOWS_S), len(LOCAL_LEVELS))))

    def __post_init__(self) -> None:
        for name in ARRAYS:
            array = np.array(getattr(self, name), np.float64)
            if not np.isfinite(array).all():
                raise ParameterError(f"{name} must be finite")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        n, gains, bins = len(self.axes), self.gains, self.equaliser.shape[-1]
        shapes = {
            "quantiles": (gains, len(LEVELS)),
            "covariance": (self.lags + 1, gains, gains),
            "offsets": (gains, gains),
            "deviation": (n,),
            "correlation": (n, n),
            "coupling": (BANDS, n, n),
            "equaliser": (n, bins),
            "spectrum": (n, bins),
            "mean": (n,),
            "local": (n if len(self.local) else 0, len(WINDOWS_S), len(LOCAL_LEVELS)),
        }
        for name, shape in shapes.items():
            if getattr(self, name).shape != shape:
                raise ParameterError(f"{name} must have the shape {shape}, got {getattr(self, name).shape}")

    @property
    def gains(self) -> int:
        """Number of gains in a frame."""
        return len(self.axes) * (BANDS + SUBFRAMES)

    @property
    def lags(self) -> int:
        """Order of the autoregression, frames."""
        return len(self.covariance) - 1

    @property
    def power(self) -> Array:
        """Mean square of each axis about its mean, shape (axis,)."""
        return np.asarray(np.exp(2 * self.deviation) + self.tones.power)

    @cached_property
    def lattice(self) -> tuple[Array, Array]:
        """Rotations (lag, 3, gain, gain) of the lattice, and the root (gain, gain) of the scores' covariance.

        A rotation is [[S, K], [-K^T, T]], kept as S, K and T: K is the partial autocorrelation of the lag. By Schur's
        algorithm on the covariances of the normalised prediction errors with the past scores.
        """
        unit = np.eye(self.covariance.shape[1])
        scores = self.covariance.copy()
        scores[0] += RIDGE * unit
        root = symmetric_root(scores[0])
        errors = np.linalg.solve(root, scores)
        forward, backward = errors[1:], errors[:-1]
        rotations = []
        for _ in range(len(scores) - 1):
            k = forward[0] @ np.linalg.inv(backward[0])
            s, t = symmetric_root(unit - k @ k.T), symmetric_root(unit - k.T @ k)
            rotations.append((s, k, t))
            forward, backward = (
                np.linalg.solve(s, forward - k @ backward)[1:],
                np.linalg.solve(t, backward - k.T @ forward)[:-1],
            )
        return np.array(rotations), root

    @cached_property
    def offset_root(self) -> Array:
        """The root of `offsets`, shape (gain, gain)."""
        return symmetric_root(self.offsets)

    @cached_property
    def coupling_root(self) -> Array:
        """Roots of `coupling`, shape (band, axis, axis)."""
        return np.array([symmetric_root(each) for each in self.coupling])

    @cached_property
    def mixing(self) -> Array:
        """Matrix (axis, axis) that gives the sources the correlation of the axes."""
        return mixing_matrix(np.exp(self.deviation), self.correlation)

    @cached_property
    def filter(self) -> Array:
        """Taps of the minimum-phase filters, shape (axis, `TAPS`)."""
        return np.array([equaliser_taps(row) for row in self.equaliser])

    def power_spectrum(self, frequencies: ArrayLike) -> Array:
        """Return the one-sided power spectral density, unit^2/Hz, float64, shape (axis, frequency).

        ``frequencies`` (Hz, ascending or not) beyond 0 and half the rate get the density there.
        """
        hz = np.linspace(0, self.rate / 2, self.spectrum.shape[1])
        points_hz = np.asarray(frequencies, np.float64)
        noise = np.exp(2 * np.array([np.interp(points_hz, hz, row) for row in self.spectrum]))
        return np.asarray(noise + self.tones.power_spectrum(points_hz))

    def log_likelihood(self, frames: ArrayLike) -> float:
        """Return the mean log-likelihood per frame of normal scores (frame, gain), an offset removed, nats."""
        z = np.asarray(frames, np.float64)
        if len(z) <= self.lags:
            raise ParameterError.must("frames", f"be more than {self.lags}", len(z))
        rotations, root = self.lattice
        forward = backward = np.linalg.solve(root, z.T)  # gain, frame
        log_determinant = np.linalg.slogdet(root)[1]
        for s, k, t in rotations:
            now, past = forward[:, 1:], backward[:, :-1]
            forward = np.linalg.solve(s, now - k @ past)
            backward = np.linalg.solve(t, past - k.T @ now)
            log_determinant += np.linalg.slogdet(s)[1]
        squares = np.mean(np.sum(forward**2, axis=0))
        return float(-0.5 * (self.gains * np.log(2 * np.pi) + squares) - log_determinant)


OTHERS = ("rate", "unit", "axes", "tones")
ARRAYS = tuple(field.name for field in fields(ModulatedNoise) if field.name not in OTHERS)


def mix(models: Sequence[ModulatedNoise], weights: ArrayLike) -> ModulatedNoise:
    """Return the model between ``models``, of one kind and order; weights >= 0 are scaled to sum to 1.

    Spectra are crossfaded in dB, tones in amplitude; the power of each axis is the mean of theirs in dB.

    A `ParameterError` if the models differ in kind or the weights are invalid.
    """
    w = checked_weights(weights, len(models))
    first = models[0]
    for model in models:
        if (model.rate, model.unit, model.axes, model.lags) != (
            first.rate,
            first.unit,
            first.axes,
            first.lags,
        ):
            raise ParameterError("models of a mix must have one rate, unit, set of axes and order")
    chosen = [model for model, share in zip(models, w, strict=True) if share > 0]
    if len(chosen) == 1:
        return chosen[0]
    w = w[w > 0] / w.sum()
    mixed: dict[str, Any] = {name: np.tensordot(w, [getattr(m, name) for m in chosen], 1) for name in ARRAYS}
    tones = mix_tones([model.tones for model in chosen], w)
    powers = [_log_power(model.spectrum, model.tones, model.rate) for model in chosen]
    missing = (np.tensordot(w, powers, 1) - _log_power(mixed["spectrum"], tones, first.rate)) / 2
    mixed["spectrum"] = mixed["spectrum"] + missing[:, None]
    mixed["equaliser"] = mixed["equaliser"] + missing[:, None]
    return replace(first, **mixed, tones=tones.scaled(np.exp(missing)))


def stretched(model: ModulatedNoise, factor: float) -> ModulatedNoise:
    """Return the model with the spectrum of its noise moved up by ``factor`` along frequency, at the same power.

    It stays as it is at both ends of the bands, where recordings were filtered.
    """
    frequency = np.linspace(0, model.rate / 2, model.spectrum.shape[1])
    moved = model.spectrum + stretch_difference(model.spectrum, frequency, factor, model.rate)
    power = [np.log(np.exp(2 * spectrum).sum(axis=-1)) for spectrum in (model.spectrum, moved)]
    moved += (power[0] - power[1])[..., None] / 2
    return replace(model, spectrum=moved, equaliser=model.equaliser + moved - model.spectrum)


def stretch_difference(spectrum: Array, frequency: Array, factor: float, rate: float) -> Array:
    """Return what a log spectrum, (axis, frequency), gains if it is moved up by ``factor`` within the bands."""
    low, high = INNER * band_edges(rate)[[0, -1]]
    inside, source = (np.clip(hz, low, high) for hz in (frequency, frequency / factor))
    return np.array(
        [np.interp(source, frequency, row) - np.interp(inside, frequency, row) for row in spectrum]
    )


def check_rate_of_noise(rate: float) -> None:
    """Refuse a ``rate`` (Hz) below `LEAST_RATE`."""
    if rate < LEAST_RATE:
        raise ParameterError.must("rate", f"be at least {LEAST_RATE:g} Hz for modulated noise", rate)


def band_edges(rate: float) -> Array:
    """Return the edges of the bands, evenly spaced on a logarithmic scale, Hz, shape (band + 1,)."""
    return np.geomspace(LOWEST_HZ, min(HIGHEST_HZ, 0.46 * rate), BANDS + 1)


@lru_cache(maxsize=32)
def band_filters(rate: float) -> Array:
    """Return the band-pass filters, second-order sections (band, 6)."""
    check_rate_of_noise(rate)
    edges = band_edges(rate)
    sections = [
        scipy.signal.butter(1, (low, high), "bandpass", fs=rate, output="sos")[0]
        for low, high in itertools.pairwise(edges)
    ]
    return np.array(sections)


def level_factor(rate: float) -> float:
    """Return the factor of the one-pole average of the short-time level: ``e += factor (x^2 - e)``."""
    return float(-np.expm1(-1 / (max(LEVEL_S * rate, 2.0))))


def frame_ends(count: int, rate: float, *, per_frame: int = 1) -> NDArray[np.int64]:
    """Return the sample after the end of each of ``count`` frames (or subframes), shape (count,)."""
    ends = np.floor(np.arange(1, count + 1) * (FRAME_S * rate / per_frame) + 0.5)
    return np.asarray(ends, np.int64)


def mixing_matrix(deviation: Array, correlation: Array) -> Array:
    """Return D R^(1/2) D^-1, shape (axis, axis), of the axes' standard deviations and correlation."""
    return deviation[:, None] * symmetric_root(correlation) / deviation


def equaliser_taps(log_magnitude: Array) -> Array:
    """Return the minimum-phase filter, shape (`TAPS`,), of a magnitude from 0 to half the rate, faded at its end."""
    size = 16 * TAPS
    dense = np.interp(np.linspace(0, 1, size // 2 + 1), np.linspace(0, 1, len(log_magnitude)), log_magnitude)
    taps = minimum_phase(dense)[:TAPS]
    fade = TAPS // 4
    taps[-fade:] *= np.hanning(2 * fade)[fade:]
    return taps


def _log_power(spectrum: Array, tones: Tones, rate: float) -> Array:
    """Return the logarithm of each axis's power."""
    width = rate / 2 / (spectrum.shape[-1] - 1)
    return np.asarray(np.log(np.exp(2 * spectrum).sum(axis=-1) * width + tones.power))
