"""Vibration features for rating: band levels and modulation."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.signal import find_peaks, hilbert

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.spectra import band_edges, band_sums
from tactogram.signal import Signal

LOWEST_HZ, HIGHEST_HZ = 5.0, 1000.0
"""Range of vibrations that are felt; above it the skin is hardly sensitive (Bolanowski et al. 1988)."""
PER_OCTAVE = 3
"""Third-octave bands: about the resolution at which people distinguish frequencies."""
RANGE_DB = 50.0
"""Floor of the bands below the whole: weaker bands are not felt."""
SILENCE = 1e-12
"""Added to powers, unit², so that silence has a level."""
ENVELOPE_RATE = 200.0
"""Hz; envelopes hold up to a quarter of it, about where flutter becomes a tone."""
MODULATIONS_HZ = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Octave bands of the envelope."""
ACTIVE_DB = 30.0
"""A vibration is on while its envelope is within this of its peak."""
DEPTH_FLOOR = 1e-4
"""Floor of modulation: a share of the mean, squared."""
LOWEST_RATE = 80.0
"""Hz: holds three octaves of the range that is felt."""


def edges(rate: float) -> NDArray[np.float64]:
    """Return the edges of the third-octave bands in a signal of ``rate`` Hz, Hz.

    Raises `ParameterError` if the rate is below `LOWEST_RATE`.
    """
    if rate < LOWEST_RATE:
        raise ParameterError.must("rate", f"be at least {LOWEST_RATE:g} Hz to be rated by", rate)
    return band_edges(LOWEST_HZ, min(HIGHEST_HZ, rate / 2), per_octave=PER_OCTAVE)


def signal_features(signal: Signal) -> NDArray[np.float64]:
    """Return features for scoring, independent of phase and start and, as far as possible, of length.

    ``signal``: over time. Axes are joined by their power: a hand does not feel directions apart (Bensmaia & Hollins
    2003).

    Raises `ParameterError` if it is over displacement or its rate is too low.

    Returns
    -------
    float64 array, shape (feature,)
        Level in each band of `edges` while it is on, dB re 1 unit²; whole level; centre (octaves re 1 Hz) and shape of
        the spectrum; peak, crest and kurtosis; modulation depth in `MODULATIONS_HZ`, dB; share of time on, onsets per
        second, place and spread of the energy in time, decay, length.
    """
    if signal.domain != "time":
        raise ParameterError("a rater needs signals over time, got one over displacement")
    x = signal.samples.astype(np.float64)
    limited, power, frequency = _felt(x - x.mean(1, keepdims=True), signal.rate)
    envelope = _envelope(limited, signal.rate)
    on = envelope > envelope.max() * 10 ** (-ACTIVE_DB / 20)
    share = max(float(on.mean()), 1 / len(on)) if envelope.max() > 0 else 1.0
    whole = power.sum()
    bands = band_sums(power, frequency, edges(signal.rate)) + whole * 10 ** (-RANGE_DB / 10) + SILENCE
    return np.concatenate(
        [
            10 * np.log10(bands / share),
            [10 * np.log10(whole / share + SILENCE)],
            _shape(bands, edges(signal.rate)),
            _peaks(limited, share),
            _depths(envelope),
            _course(envelope, on, signal.seconds),
        ]
    )


def _felt(
    x: NDArray[np.float64], rate: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the signal limited to the range that is felt, and its power by frequency, summed over axes.

    Signals shorter than a second are padded with zeros, so that every band holds a bin.
    """
    length = x.shape[1]
    size = next_fast_len(max(length, round(rate)) * 2, real=True)
    spectrum = rfft(x, size, axis=1)
    frequency = rfftfreq(size, 1 / rate)
    spectrum[:, (frequency < LOWEST_HZ) | (frequency > HIGHEST_HZ)] = 0
    power = 2 * (np.abs(spectrum) ** 2).sum(0) / (size * length)
    return np.asarray(irfft(spectrum, size, axis=1)[:, :length]), power, frequency


def _envelope(x: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """Return the root of the instantaneous power over axes in steps of 1 / `ENVELOPE_RATE` s, shape (step,)."""
    power = (np.abs(hilbert(x, next_fast_len(x.shape[1]), axis=1)[:, : x.shape[1]]) ** 2).sum(0)
    steps = max(4, round(len(power) / rate * ENVELOPE_RATE))
    bounds = np.linspace(0, len(power), steps + 1)
    summed = np.interp(bounds, np.arange(len(power) + 1), np.concatenate([[0.0], np.cumsum(power)]))
    return np.asarray(np.sqrt(np.maximum(np.diff(summed) / np.diff(bounds), 0)))


def _shape(bands: NDArray[np.float64], band_edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return centre, spread and strongest band in octaves, and flatness in dB."""
    octave = np.log2(np.sqrt(band_edges[1:] * band_edges[:-1]))
    weight = bands / bands.sum()
    centre = float(weight @ octave)
    spread = float(np.sqrt(weight @ (octave - centre) ** 2))
    flatness = 10 * float(np.mean(np.log10(weight)) - np.log10(weight.mean()))
    return np.array([centre, spread, octave[bands.argmax()], flatness])


def _peaks(x: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Return peak level in dB, crest factor in dB while it is on, and the logarithm of kurtosis."""
    power = (x**2).sum(0)
    mean, peak = power.mean() + SILENCE, power.max() + SILENCE
    kurtosis = (x**4).sum(0).mean() / (mean**2 + SILENCE**2) + 1e-3
    return np.array([10 * np.log10(peak), 10 * np.log10(peak * share / mean), np.log(kurtosis)])


def _depths(envelope: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the envelope's power in each of `MODULATIONS_HZ`, dB re its squared mean."""
    relative = envelope / (envelope.mean() + np.sqrt(SILENCE))
    relative = (relative - relative.mean()) * np.hanning(len(envelope) + 2)[1:-1]
    size = max(len(envelope), round(4 * ENVELOPE_RATE))
    power = 2 * np.abs(rfft(relative, size)) ** 2 / (size * len(envelope) * 0.375)
    bounds = np.array([c / np.sqrt(2) for c in (*MODULATIONS_HZ, 2 * MODULATIONS_HZ[-1])])
    return np.asarray(
        10 * np.log10(band_sums(power, rfftfreq(size, 1 / ENVELOPE_RATE), bounds) + DEPTH_FLOOR)
    )


def _course(envelope: NDArray[np.float64], on: NDArray[np.bool_], seconds: float) -> NDArray[np.float64]:
    """Return share of time on, onsets per second, place of the energy (0..1), its spread, decay, log2 of the length."""
    top = envelope.max() + np.sqrt(SILENCE)
    smooth = np.convolve(envelope / top, np.full(5, 0.2), mode="same")
    onsets = len(find_peaks(np.concatenate([[0.0], smooth, [0.0]]), prominence=0.2)[0])
    position = (np.arange(len(envelope)) + 0.5) / len(envelope)
    energy = envelope**2 + SILENCE
    centre = float(energy @ position / energy.sum())
    spread = float(np.sqrt(energy @ (position - centre) ** 2 / energy.sum()))
    after = smooth[int(smooth.argmax()) :]
    decay = float(np.log2(max(int(np.argmax(after < 0.25 * after[0])) or len(after), 1) / ENVELOPE_RATE))
    return np.array(
        [
            float(on.mean()),
            np.log2(onsets / seconds + 0.25),
            centre,
            spread,
            decay,
            np.log2(seconds + 0.05),
        ]
    )
