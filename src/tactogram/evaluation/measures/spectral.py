"""Spectral and level distances of two sets of signals: blind to phase, in physical units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch
from scipy.special import digamma

from tactogram.errors import ParameterError
from tactogram.evaluation.measures.bands import band_sums, felt_edges, felt_floor_db, felt_weight
from tactogram.evaluation.measures.sets import check_alike, stacks
from tactogram.signal import Signal

SEGMENT_S = 0.25
"""Length of the segments that a spectrum is averaged over, s: bins of 4 Hz."""

BAND_HZ = (10.0, 1000.0)
"""Compared by default: below is movement and drift, above hardly anything is felt."""

DYNAMIC_RANGE_DB = 80.0
"""Bins farther than this below the strongest of both sets count as that: what a filter or a converter left of
a band says nothing about a texture."""

SILENT = 1e-30
"""Power that stands for none where a logarithm is taken."""

HANN_BINS = 1.5
"""Bandwidth of the Hann window in bins."""


def log_spectral_distance(
    one: Sequence[Signal], other: Sequence[Signal], *, band: tuple[float, float] = BAND_HZ
) -> float:
    """Return the root mean square difference of two mean spectra in dB, over frequency and axes.

    sqrt(mean over f and axes of (L1(f) - L2(f))^2), where L is the mean over a set's signals of
    10 log10 of their power spectra (Welch 1967, Hann segments of `SEGMENT_S`, half overlapping). The level
    counts; phase, order and alignment do not. 0 dB is identical; two recordings of one texture are some dB
    apart, which is the floor to hold a generator against.

    The logarithm of a spectrum from K independent segments is low by 10/ln 10 (ln K - digamma(K)) dB on average
    (2.5 dB for one); that is added, so that signals of different lengths can be compared.

    Parameters
    ----------
    one, other : sequence of Signal
        All of one rate, unit and set of axes, over time, at least `SEGMENT_S` long.
    band : (float, float), Hz
        What is compared; cut to what the rate holds.

    Returns
    -------
    float
        dB, >= 0.

    Raises
    ------
    ParameterError
        If the signals are not of one kind, too short, or the band holds nothing.

    References
    ----------
    A. H. Gray, J. D. Markel, "Distance measures for speech processing", IEEE Trans. ASSP 24 (1976) 380-391.
    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73, for the estimate.
    """
    check_alike(one, other, shortest_s=SEGMENT_S)
    spectra = [power_spectra(members) for members in (one, other)]
    kept = _within(spectra[0].frequency, band)
    floor = 10 ** (-DYNAMIC_RANGE_DB / 10) * max(s.power[..., kept].max() for s in spectra)
    if floor == 0:
        return 0.0
    first, second = (_mean_db(np.maximum(s.power[..., kept], floor), s.independent) for s in spectra)
    return float(np.sqrt(np.mean((first - second) ** 2)))


def weighted_log_spectral_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the root mean square difference of two mean spectra in dB, each band by how much of it is felt.

    sqrt(sum w D^2 / sum w) over third octaves of `FELT_HZ` and axes. L1, L2 are the sets' mean levels in a
    band relative to the detection threshold, raised to the floor of what is felt at all; D = L1 - L2 and
    w = max(L1, L2) - floor. A level error of x dB is x dB; a band that is felt in neither set does not count.

    The floor is 50 dB below the strongest band, but not lower than 20 dB below the threshold, which is how much
    more sensitive some people are. For units that have no threshold (sound, counts, V, N) only the shape of a
    threshold curve is used (see `bands.FELT_LIKE`), and the floor is relative alone: a level error still
    counts, how near to the threshold it is cannot.

    Parameters
    ----------
    one, other : sequence of Signal
        All of one rate, unit and set of axes, over time, at least `SEGMENT_S` long; above 40 Hz in rate.

    Returns
    -------
    float
        dB, >= 0.

    Raises
    ------
    ParameterError
        If the signals are not of one kind, too short, or of a rate that holds no vibration.

    References
    ----------
    The distance: Gray and Markel 1976, as in `log_spectral_distance`. The threshold and what is known of it:
    `tactogram.signal.perception` (Verrillo 1963). Bands, floor and weight are this project's choice.
    """
    kind = check_alike(one, other, shortest_s=SEGMENT_S)
    edges = felt_edges(kind.rate)
    first, second = _felt_levels(one, edges), _felt_levels(other, edges)
    floor = felt_floor_db(kind.unit, first, second)
    first, second = np.maximum(first, floor), np.maximum(second, floor)
    weight = np.maximum(first, second) - floor
    if not weight.any():
        return 0.0
    return float(np.sqrt(np.sum(weight * (first - second) ** 2) / np.sum(weight)))


def level_difference_db(
    one: Sequence[Signal], other: Sequence[Signal], *, band: tuple[float, float] = BAND_HZ
) -> float:
    """Return by how much two sets differ in level.

    abs(mean L1 - mean L2), where L is 10 log10 of a signal's mean square within ``band``, axes added up. Blind to
    everything else.

    Parameters
    ----------
    one, other, band
        As in `log_spectral_distance`.

    Returns
    -------
    float
        dB, >= 0. Silence counts as a mean square of `SILENT`.

    Raises
    ------
    ParameterError
        As in `log_spectral_distance`.
    """
    check_alike(one, other, shortest_s=SEGMENT_S)
    first, second = (_level(members, band) for members in (one, other))
    return abs(first - second)


@dataclass(frozen=True, eq=False)
class Spectra:
    """The power spectra of a set.

    Parameters
    ----------
    frequency : float64 array, shape (frequency,), Hz
    power : float64 array, shape (signal, axis, frequency), unit^2/Hz
        One-sided. Signals in the order of `stacks`.
    independent : float64 array, shape (signal,)
        How many independent segments each was averaged over.
    """

    frequency: NDArray[np.float64]
    power: NDArray[np.float64]
    independent: NDArray[np.float64]


def power_spectra(signals: Sequence[Signal]) -> Spectra:
    """Return the power spectra of ``signals`` (Welch, Hann segments of `SEGMENT_S`, half overlapping)."""
    rate = signals[0].rate
    length = round(SEGMENT_S * rate)
    if length < 4:
        raise ParameterError(f"rate must be at least {4 / SEGMENT_S:g} Hz for a spectrum, got {rate:g}")
    powers, independent = [], []
    for stack in stacks(signals):
        frequency, power = welch(stack, rate, nperseg=length, axis=-1)
        powers.append(power)
        count = (stack.shape[-1] - length // 2) // (length - length // 2)
        # Hann windows that overlap by half share (1/6)^2 of their power's variance.
        independent += [count / (1 + 2 * (count - 1) / count / 36)] * len(stack)
    return Spectra(frequency, np.concatenate(powers), np.array(independent))


def _mean_db(power: NDArray[np.float64], independent: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean over signals in dB, unbiased, shape (axis, frequency).

    ``independent`` is how many independent estimates each power is the mean of, shape (signal, ...).
    """
    bias = 10 / np.log(10) * (digamma(independent) - np.log(independent))
    bias = bias.reshape(len(power), 1, -1)
    return np.asarray(np.mean(10 * np.log10(np.maximum(power, SILENT)) - bias, axis=0))


def _felt_levels(signals: Sequence[Signal], edges: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean level per band in dB re threshold (0 dB is a sine at threshold), shape (axis, band)."""
    spectra = power_spectra(signals)
    weight = np.zeros(len(spectra.frequency))
    weight[1:] = felt_weight(spectra.frequency[1:], signals[0].unit)
    spacing = spectra.frequency[1]
    felt = 2 * spacing * band_sums(spectra.power * weight, spectra.frequency, edges)
    estimates = np.maximum(1.0, np.diff(edges) / (HANN_BINS * spacing))
    return _mean_db(felt, spectra.independent[:, None] * estimates)


def _level(signals: Sequence[Signal], band: tuple[float, float]) -> float:
    spectra = power_spectra(signals)
    total = spectra.power[..., _within(spectra.frequency, band)].sum(axis=(1, 2)) * spectra.frequency[1]
    return float(np.mean(10 * np.log10(np.maximum(total, SILENT))))


def _within(frequency: NDArray[np.float64], band: tuple[float, float]) -> NDArray[np.bool_]:
    kept = (frequency >= band[0]) & (frequency <= band[1])
    if not kept.any():
        raise ParameterError(
            f"band must hold a frequency below {frequency[-1]:g} Hz, got {band[0]:g} {band[1]:g} Hz"
        )
    return kept
