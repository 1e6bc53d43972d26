"""Fitting of modulated noise and tones to recordings; the spectrum of the noise is corrected twice."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.signal.autoregressive import symmetric_root
from tactogram.signal.local_amplitudes import local_quantiles
from tactogram.signal.modulated_noise import (
    BANDS,
    FRAME_S,
    LEVELS,
    SCORES,
    SUBFRAMES,
    ModulatedNoise,
    band_edges,
    band_filters,
    check_rate_of_noise,
    frame_ends,
    level_factor,
    mixing_matrix,
)
from tactogram.signal.modulated_noise_synthesis import synthesise_modulated_noise
from tactogram.signal.signal import Signal
from tactogram.signal.tone_fit import split_tones
from tactogram.signal.tones import no_tones

Array = NDArray[np.float64]

LAGS = 10
"""Order of the autoregression, frames: 0.1 s."""
CORRECTIONS = 2
"""Times that the spectrum of what is synthesised is compared with the recorded one."""
SEED = 0
"""Of the signals that are synthesised for it."""
SEGMENT_S = 0.25
"""Segments of the spectra, s: bins of 4 Hz."""
FAINTEST = 1e-6
"""Lowest amplitude, as a share of the loudest axis's rms."""
SILENT = 1e-30
"""Least power density."""
NUGGET = 0.01
"""Added to the variance of correlated axes: a combination of others is not their exact sum."""
STRONGEST_CORRECTION = np.log(1e4)
"""Of the spectrum, both ways: 80 dB."""


def fit_modulated_noise(signals: Signal | Sequence[Signal], *, lags: int = LAGS) -> ModulatedNoise:
    """Fit one model to one recording, or to several of one texture.

    Parameters
    ----------
    signals : Signal or sequence of Signal
        Over time; equal in rate, unit and axes; their lengths may differ. Those below 0.25 s are left out.
    lags : int
        Order of the autoregression, frames of 10 ms, >= 1.

    Raises
    ------
    ParameterError
        If the signals differ in kind, are over displacement or too slow, or the longest is too short for the order.
    """
    members = (signals,) if isinstance(signals, Signal) else tuple(signals)
    _check(members, lags)
    first = members[0]
    rate = first.rate
    members = tuple(s for s in members if len(s) >= round(SEGMENT_S * rate))
    mean = np.average(
        [s.samples.mean(1, dtype=np.float64) for s in members], axis=0, weights=[len(s) for s in members]
    )
    recordings = [s.samples - s.samples.mean(1, keepdims=True, dtype=np.float64) for s in members]
    patterns, recordings = split_tones(recordings, rate, band=band_edges(rate)[[0, -1]])
    deviation, correlation = _correlation(recordings)
    unmixing = np.linalg.inv(mixing_matrix(deviation, correlation))
    sources = [unmixing @ x for x in recordings]
    faintest = FAINTEST * deviation.max()
    frames = [gains_of(x, rate, faintest) for x in sources]
    every = np.concatenate(frames)
    quantiles = np.quantile(every, LEVELS, axis=0).T
    scores = [normal_scores(each, quantiles) for each in frames]
    means = np.array([each.mean(axis=0) for each in scores])
    centred = [each - own for each, own in zip(scores, means, strict=True)]
    covariance = np.array(
        [sum(z[lag:].T @ z[: len(z) - lag] for z in centred if len(z) > lag) for lag in range(lags + 1)]
    ) / len(every)
    spectrum = _log_amplitude(recordings, rate)
    model = ModulatedNoise(
        quantiles=quantiles,
        covariance=covariance,
        offsets=means.T @ means / max(1, len(means) - 1),
        deviation=np.log(deviation),
        correlation=correlation,
        coupling=_coherence(sources, rate),
        equaliser=np.zeros_like(spectrum),
        spectrum=spectrum,
        mean=mean,
        rate=rate,
        unit=first.unit,
        axes=first.axes,
        tones=no_tones(len(first.axes)),
    )
    return replace(
        _with_spectrum(model, recordings),
        tones=patterns[0] if patterns else model.tones,
        local=local_quantiles(recordings, rate),
    )


def log_likelihood(model: ModulatedNoise, signal: Signal) -> float:
    """Return the mean log-likelihood per frame of the normal scores of a recording's gains, nats.

    Its own offset and tones are removed, as in the fit. Raises `ParameterError` if it is not longer than the model's
    order.
    """
    x = signal.samples - signal.samples.mean(axis=1, keepdims=True, dtype=np.float64)
    _, [x] = split_tones([x], model.rate, band=band_edges(model.rate)[[0, -1]])
    faintest = FAINTEST * float(np.exp(model.deviation.max()))
    sources = np.linalg.inv(model.mixing) @ x
    scores = normal_scores(gains_of(sources, model.rate, faintest), model.quantiles)
    return model.log_likelihood(scores - scores.mean(axis=0))


def gains_of(samples: Array, rate: float, faintest: float) -> Array:
    """Return the logarithms of the gains of each frame, shape (frame, gain); samples (axis, time) have mean 0."""
    return np.hstack([_gains_of_axis(x, rate, faintest) for x in samples])


def normal_scores(gains: Array, quantiles: Array) -> Array:
    """Return the normal scores of gains (frame, gain) whose distributions are ``quantiles`` (gain, quantile)."""
    return np.stack([np.interp(x, q, SCORES) for x, q in zip(gains.T, quantiles, strict=True)], axis=1)


def _gains_of_axis(x: Array, rate: float, faintest: float) -> Array:
    """Return the gains of the bands at the ends of frames, and the level at the ends of subframes."""
    count = int(len(x) / (FRAME_S * rate))
    ends = frame_ends(count, rate)
    ends = ends[ends <= len(x)]
    hop = max(1, round(FRAME_S * rate))
    low, high = np.maximum(ends - hop, 0), np.minimum(ends + hop, len(x))
    powers = []
    for section in band_filters(rate):
        total = np.concatenate(
            (
                [0.0],
                np.cumsum(scipy.signal.sosfiltfilt(section[None], x, padlen=min(len(x) - 1, 3 * hop)) ** 2),
            )
        )
        powers.append((total[high] - total[low]) / (high - low))
    factor = level_factor(rate)
    level = scipy.signal.lfilter([factor], [1, factor - 1], x**2)
    powers += list(
        level[frame_ends(SUBFRAMES * len(ends), rate, per_frame=SUBFRAMES) - 1].reshape(-1, SUBFRAMES).T
    )
    return np.asarray(0.5 * np.log(np.maximum(np.array(powers).T, faintest**2)))


def _coherence(signals: Sequence[NDArray[np.floating]], rate: float) -> Array:
    """Return a correlation of the axes of signals (axis, time) in each band, shape (band, axis, axis).

    Its square is the mean magnitude-squared coherence in the band, its sign that of the real part.
    """
    length = round(SEGMENT_S * rate)
    frequency = np.fft.rfftfreq(length, 1 / rate)
    axes = len(signals[0])
    spectra = np.zeros((axes, axes, len(frequency)), complex)
    segments = 0
    for x in signals:
        for a, b in np.ndindex(axes, axes):
            spectra[a, b] += scipy.signal.csd(x[a], x[b], rate, nperseg=length)[1] * x.shape[1]
        segments += 2 * x.shape[1] // length - 1
    own = np.sqrt(np.maximum(np.einsum("aaf->af", spectra).real, SILENT))
    coherency = spectra / (own[:, None] * own[None])
    # The mean of K segments of independent axes is 1 / K.
    chance = 1 / max(2, segments)
    square = np.maximum(np.abs(coherency) ** 2 - chance, 0) / (1 - chance)
    correlations = np.tile(np.eye(axes), (BANDS, 1, 1))
    for band, (low, high) in enumerate(itertools.pairwise(band_edges(rate))):
        inside = (frequency >= low) & (frequency < high)
        sign = np.where(coherency[..., inside].real.sum(axis=-1) < 0, -1.0, 1.0)
        correlations[band] = sign * np.sqrt(square[..., inside].mean(axis=-1))
        np.fill_diagonal(correlations[band], 1.0)
        root = symmetric_root(correlations[band])
        root /= np.sqrt(np.sum(root**2, axis=1, keepdims=True))
        correlations[band] = root @ root.T
    return correlations


def _correlation(recordings: Sequence[Array]) -> tuple[Array, Array]:
    """Return the standard deviations of the axes and their correlation, positive definite."""
    covariance = sum(x @ x.T for x in recordings) / sum(x.shape[1] for x in recordings)
    deviation = np.sqrt(np.diag(covariance))
    deviation = np.maximum(deviation, max(FAINTEST * deviation.max(), 1e-12))
    correlation = covariance / np.outer(deviation, deviation)
    np.fill_diagonal(correlation, 1.0)
    return deviation, (correlation + NUGGET * np.eye(len(deviation))) / (1 + NUGGET)


def _with_spectrum(model: ModulatedNoise, recordings: Sequence[Array]) -> ModulatedNoise:
    """Return the model with the filters that give what is synthesised the recorded spectrum."""
    rate = model.rate
    random = np.random.default_rng(SEED)
    for _ in range(CORRECTIONS):
        signals = [
            synthesise_modulated_noise(model, 2 * x.shape[1] / rate, seed=random).samples for x in recordings
        ]
        corrected = model.equaliser + model.spectrum - _log_amplitude(signals, rate)
        model = replace(model, equaliser=np.clip(corrected, -STRONGEST_CORRECTION, STRONGEST_CORRECTION))
    return model


def _log_amplitude(signals: Sequence[NDArray[np.floating]], rate: float) -> Array:
    """Return the mean logarithm of the amplitude spectra of signals (axis, time), shape (axis, frequency)."""
    density = [scipy.signal.welch(x, rate, nperseg=round(SEGMENT_S * rate), axis=-1)[1] for x in signals]
    amplitude: Array = np.mean(0.5 * np.log(np.maximum(density, SILENT)), axis=0)
    amplitude[:, 0] = amplitude[:, 1]  # a constant is removed
    return amplitude


def _check(signals: Sequence[Signal], lags: int) -> None:
    if not signals:
        raise ParameterError("a fit needs at least one recording")
    if lags < 1:
        raise ParameterError.must("lags", "be >= 1", lags)
    first = signals[0]
    check_rate_of_noise(first.rate)
    for signal in signals:
        if signal.domain != "time":
            raise ParameterError(
                "modulated noise is over time; give recordings over time, not over displacement"
            )
        if (signal.rate, signal.unit, signal.axes) != (first.rate, first.unit, first.axes):
            raise ParameterError("recordings of a fit must have one rate, unit and set of axes")
    needed = max(SEGMENT_S, (lags + 2) * FRAME_S)
    if max(signal.seconds for signal in signals) < needed:
        raise ParameterError(
            f"the longest recording must have at least {needed:g} s, got {max(s.seconds for s in signals):g}"
        )
