"""Envelope and modulation distances of two sets of signals: blind to phase and level.

Two textures of one spectrum feel different when one is even and the other comes in bursts, ridges or slips. A
power spectrum cannot see that; the spectrum of an envelope can.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.signal import welch

from tactogram.evaluation.measures.bands import band_edges, band_sums, check_felt, felt_floor_db, felt_weight
from tactogram.evaluation.measures.sets import check_alike, stacks
from tactogram.evaluation.measures.spectral import SILENT
from tactogram.signal import Signal
from tactogram.signal.perception import FELT_HZ

MODULATION_HZ = (2.0, 100.0)
"""Slower is how the hand moves, faster is felt as frequency rather than fluctuation."""

WINDOW_S = 1.0
"""Length of the Hann windows that an envelope's spectrum is averaged over, s; the length of the shortest signal
where that is less, and the slowest modulation that is seen is then 2 / length."""

SHORTEST_S = 0.5
"""Signals must last as long as this, s."""

MODULATION_FLOOR_DB = -40.0
"""Modulation that is less than this in a band counts as this: a depth of 1.4 %, which nobody feels."""

CENTRES_HZ = tuple(40.0 * 2.0**k for k in range(5))
"""Of the bands whose envelopes are taken, Hz: each reaches from half to twice its centre, so that together they
hold `FELT_HZ` and their powers add up to the signal's."""


def envelope_spectrum_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the root mean square difference in dB of two mean envelope spectra, over bands and axes.

    The Hilbert envelope of a signal within 20-1000 Hz is divided by its mean; the power spectrum of that, summed
    in half octaves of 2-100 Hz, is averaged over the set in dB. A modulation of depth m at one frequency has
    10 log10(m^2 / 2) dB; less than `MODULATION_FLOOR_DB` counts as that. Blind to level and to the phase of
    carrier and modulation. A narrow band beats of itself, so that a spectrum of another width shows a little.

    Parameters
    ----------
    one, other : sequence of Signal
        All of one rate, unit and set of axes, over time, at least 0.5 s long, better 1 s and more; of equal
        length (`segments`): the logarithm of an average of few windows is low by up to 2.5 dB.

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
    Envelope spectra: R. B. Randall, J. Antoni, "Rolling element bearing diagnostics: a tutorial", Mech. Syst.
    Signal Process. 25 (2011) 485-520. Bands and floor are this project's choice.
    """
    kind = check_alike(one, other, shortest_s=SHORTEST_S)
    check_felt(kind.rate)
    window = _window(one, other)
    edges = _modulation_edges(kind.rate, window, MODULATION_HZ[1], per_octave=2)
    first, second = (_envelope_spectrum(members, window, edges) for members in (one, other))
    return float(np.sqrt(np.mean((first - second) ** 2)))


def modulation_spectrum_distance(one: Sequence[Signal], other: Sequence[Signal]) -> float:
    """Return the root mean square difference in dB of two modulation spectra, over both frequencies and axes.

    Like `envelope_spectrum_distance`, but by carrier: the Hilbert envelope of each octave-wide band (`CENTRES_HZ`,
    half-cosine on a logarithmic scale) is divided by its mean, and its power is summed in octaves from 2 Hz to
    half the band's centre, 100 Hz at most. sqrt(sum w D^2 / sum w), where w is by how many dB a carrier band,
    weighted with the shape of the detection threshold, is above a floor 50 dB below the strongest, in the set
    where it is more: a band that is not there does not count. Blind to level, phase, and to how bands move
    together.

    Parameters
    ----------
    one, other : sequence of Signal
        As in `envelope_spectrum_distance`.

    Returns
    -------
    float
        dB, >= 0.

    Raises
    ------
    ParameterError
        As in `envelope_spectrum_distance`.

    References
    ----------
    T. Dau, B. Kollmeier, A. Kohlrausch, J. Acoust. Soc. Am. 102 (1997) 2892-2905: modulation filter bank.
    J. H. McDermott, E. P. Simoncelli, "Sound texture perception via statistics of the auditory periphery",
    Neuron 71 (2011) 926-940: modulation power per band, normalised by the band's envelope. The carrier bands
    are ours: touch has no cochlea.
    """
    kind = check_alike(one, other, shortest_s=SHORTEST_S)
    check_felt(kind.rate)
    window = _window(one, other)
    centres = [c for c in CENTRES_HZ if c * np.sqrt(2) <= kind.rate / 2] or [CENTRES_HZ[0]]
    first, second = (_modulation_spectrum(members, window, centres) for members in (one, other))
    felt = 10 * np.log10(felt_weight(np.array(centres), kind.unit))
    levels = np.maximum(first[1], second[1]) + felt  # axis, carrier
    # The floor is relative alone: like the measure, the weight is blind to level.
    weight = np.maximum(levels - felt_floor_db("1", levels), 0)
    squares = np.stack(
        [np.sum((a - b) ** 2, axis=1) for a, b in zip(first[0], second[0], strict=True)], axis=1
    )
    counts = np.array([spectrum.shape[1] for spectrum in first[0]])
    return float(np.sqrt(np.sum(weight * squares) / np.sum(weight * counts)))


def envelopes(
    stack: NDArray[np.float64],
    rate: float,
    low: float,
    high: float,
    gain: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> tuple[NDArray[np.float64], float]:
    """Return the Hilbert envelopes of a band, at a rate just high enough for them.

    The magnitude of the analytic signal (Gabor 1946). Only the bins of the band are transformed back: a shift
    in frequency changes no magnitude, so that a narrow band costs little. The signal is continued by its mirror
    image, so that its ends make no step.

    Parameters
    ----------
    stack : float64 array, shape (..., time)
    rate : float, Hz
    low, high : float, Hz
        The band; cut at half the rate.
    gain : function of float64 array, Hz
        What a frequency of the band is multiplied with.

    Returns
    -------
    envelope : float64 array, shape (..., time)
        >= 0; of a sine its amplitude.
    rate : float, Hz
        At least twice the band's width and four times the fastest modulation, where the signal has that much.
    """
    length = 2 * stack.shape[-1]
    spectrum = fft.rfft(np.concatenate([stack, stack[..., ::-1]], axis=-1), axis=-1)
    first = max(1, int(np.ceil(low * length / rate)))
    last = min(length // 2 - 1, int(np.floor(high * length / rate)))
    band = spectrum[..., first : last + 1] * gain(np.arange(first, last + 1) * rate / length)
    needed = max(2 * (last + 1 - first), int(np.ceil(4 * MODULATION_HZ[1] * length / rate)))
    points = 2 * fft.next_fast_len(-(-needed // 2))
    analytic = fft.ifft(band, n=points, axis=-1)[..., : points // 2]
    return np.abs(analytic) * (2 * points / length), rate * points / length


def modulation_power(
    envelope: NDArray[np.float64], rate: float, window_s: float, edges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the power of an envelope's fluctuation around its mean of 1, summed in bands.

    Parameters
    ----------
    envelope : float64 array, shape (..., time)
    rate : float, Hz
    window_s : float
        Length of the Hann windows, half overlapping (Welch 1967).
    edges : float64 array, shape (band + 1,), Hz

    Returns
    -------
    float64 array, shape (..., band)
        m^2 / 2 for a modulation of depth m; 0 for an envelope that is 0 throughout.
    """
    mean = envelope.mean(axis=-1, keepdims=True)
    relative = np.divide(envelope, mean, out=np.ones_like(envelope), where=mean > 0)
    length = min(envelope.shape[-1], round(window_s * rate))
    frequency, power = welch(relative, rate, nperseg=length, axis=-1)
    return np.asarray(band_sums(power, frequency, edges) * frequency[1])


def _envelope_spectrum(
    signals: Sequence[Signal], window: float, edges: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the mean envelope spectrum of a set, dB, shape (axis, band)."""
    power = []
    for stack in stacks(signals):
        envelope, rate = envelopes(stack, signals[0].rate, *FELT_HZ, np.ones_like)
        power.append(modulation_power(envelope, rate, window, edges))
    return _mean_db(np.concatenate(power))


def _modulation_spectrum(
    signals: Sequence[Signal], window: float, centres: Sequence[float]
) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]]:
    """Return a set's mean modulation spectrum and levels by carrier.

    Returns
    -------
    spectra : list of float64 array, one per carrier, shape (axis, modulation band)
        dB.
    levels : float64 array, shape (axis, carrier)
        Mean square of the envelope, dB.
    """
    own = signals[0].rate
    edges = [_modulation_edges(own, window, min(c / 2, MODULATION_HZ[1]), per_octave=1) for c in centres]
    power: list[list[NDArray[np.float64]]] = [[] for _ in centres]
    square = np.zeros((len(signals[0].axes), len(centres)))
    for stack in stacks(signals):
        for band, centre in enumerate(centres):
            envelope, rate = envelopes(stack, own, centre / 2, centre * 2, _half_cosine(centre))
            power[band].append(modulation_power(envelope, rate, window, edges[band]))
            square[:, band] += np.mean(envelope**2, axis=-1).sum(axis=0)
    levels = 10 * np.log10(np.maximum(square / len(signals), SILENT))
    return [_mean_db(np.concatenate(members)) for members in power], levels


def _half_cosine(centre: float) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    return lambda frequency: np.cos(np.pi / 2 * np.clip(np.log2(frequency / centre), -1, 1))


def _window(*sets: Sequence[Signal]) -> float:
    """Return the length of the windows that all of ``sets`` have, s."""
    return min(WINDOW_S, *(signal.seconds for members in sets for signal in members))


def _modulation_edges(rate: float, window: float, high: float, *, per_octave: int) -> NDArray[np.float64]:
    return band_edges(max(MODULATION_HZ[0], 2 / window), min(high, rate / 2), per_octave=per_octave)


def _mean_db(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean over signals in dB, not below the floor, shape (axis, band)."""
    floor = 10 ** (MODULATION_FLOOR_DB / 10)
    return np.asarray(np.mean(10 * np.log10(np.maximum(power, floor)), axis=0))
