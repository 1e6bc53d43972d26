"""Signal traits behind the pictures: levels, envelope, spectrogram and bands, computed once.

All are pure functions of a signal and slow for minutes of samples: pages call `traits_of` in a thread.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from tactogram.signal import FELT_HZ, Domain, Signal, sensation_level_db

WIDTH = 600
"""Width of a waveform's picture, pixels."""
WITH_THRESHOLD = ("m", "m/s", "m/s^2")
ACCURACY_DB = 10.0
"""Of absolute thresholds; see `tactogram.signal.perception`."""
MOSTLY_OUTSIDE = 0.1
"""Share of the power within the felt range below which a signal is called mostly outside of it."""
MOMENT_S = 0.2
"""Length of the moments of which the strongest decides whether a signal is felt: about that of a tap with its decay."""
BANDS_PER_DECADE = 10
"""Third octaves, base ten (IEC 61260-1)."""
UNITS = {"m/s^2": "m/s²", "1": "no unit"}
AT_ONCE = 2**20
"""Samples that are transformed at once, which limits memory for a long signal."""


@dataclass(frozen=True, eq=False)
class SignalTraits:
    """Traits of a signal for pictures and texts; their size does not depend on its length.

    Parameters
    ----------
    rate : float, Hz or samples per mm
    unit : str
    domain : {"time", "displacement"}
    axes : tuple of str
    extent : float, s or mm
    rms, peak : float, in the unit
        See `rms_of` and `peak_of`.
    note : str
    felt : bool
        See `threshold_note`.
    curves : tuple of (int64 array, float32 array)
        By axis, mean removed; see `envelope`.
    frequency : float64 array, shape (frequency,), Hz or cycles per mm
    level : float32 array, shape (frequency, time), dB re 1 unit
        See `spectrogram_db`.
    bands : tuple of (float64 array, float64 array)
        See `band_levels`.
    """

    rate: float
    unit: str
    domain: Domain
    axes: tuple[str, ...]
    extent: float
    rms: float
    peak: float
    note: str
    felt: bool
    curves: tuple[tuple[NDArray[np.int64], NDArray[np.float32]], ...]
    frequency: NDArray[np.float64]
    level: NDArray[np.float32]
    bands: tuple[NDArray[np.float64], NDArray[np.float64]]

    @property
    def top_hz(self) -> float:
        """Highest frequency of its spectrogram, Hz or cycles per mm."""
        return _top_hz(self)


def traits_of(signal: Signal) -> SignalTraits:
    """Return the traits of a signal."""
    x = centred(signal)
    frequency, _, level = spectrogram_db(signal)
    return SignalTraits(
        signal.rate,
        signal.unit,
        signal.domain,
        signal.axes,
        signal.extent,
        rms_of(signal),
        peak_of(signal),
        *threshold_note(signal),
        tuple(envelope(axis.astype(np.float32), WIDTH) for axis in x),
        frequency,
        level.astype(np.float32),
        band_levels(signal),
    )


@dataclass(frozen=True)
class SharedScales:
    """Scales shared by the pictures of several signals.

    ``peak`` is the largest deviation from an axis' mean, ``extent`` the longest (s or mm), ``top_db`` the brightest
    level (a multiple of 10, dB re 1 unit) and ``top_hz`` the highest frequency (Hz, or cycles per mm) of the
    spectrograms.
    """

    peak: float
    extent: float
    top_db: float
    top_hz: float


def scales_of(signals: Sequence[SignalTraits]) -> SharedScales:
    """Return the scales that fit all signals (at least one)."""
    return SharedScales(
        peak=max(traits.peak for traits in signals) or 1.0,
        extent=max(traits.extent for traits in signals),
        top_db=10 * math.ceil(max(float(traits.level.max()) for traits in signals) / 10),
        top_hz=max(traits.top_hz for traits in signals),
    )


def rms_of(signal: Signal) -> float:
    """Return the rms about the mean of all axes together, equal to that of their DFT321."""
    return float(np.sqrt(centred(signal).var(axis=1).sum()))


def peak_of(signal: Signal) -> float:
    """Return the largest deviation of any axis from its mean."""
    return float(np.abs(centred(signal)).max())


def unit_text(unit: str) -> str:
    """Return a unit for pages, such as m/s²."""
    return UNITS.get(unit, unit)


def threshold_note(signal: Signal) -> tuple[str, bool]:
    """Return a sentence on the level relative to the detection threshold, or why there is none, and whether it is felt.

    It is felt if its strongest moment is above the threshold (see `strongest_db`), or where that is not known.
    """
    if peak_of(signal) == 0:
        return "The signal is silent: it cannot be felt.", False
    if signal.domain != "time":
        return "A signal over displacement is felt at a speed only: no threshold is drawn.", True
    if signal.unit not in WITH_THRESHOLD:
        unit = "without a unit" if signal.unit == "1" else f"in {unit_text(signal.unit)}"
        return f"No detection threshold is known {unit}.", True
    level = sensation_level_db(signal)
    side = "above" if level >= 0 else "below"
    note = f"{abs(level):.0f} dB {side} the detection threshold (accurate to about {ACCURACY_DB:g} dB)."
    if level >= 0:
        return note, True
    strongest = strongest_db(signal)
    if strongest >= 0:
        return f"{note} Its strongest moment is {strongest:.0f} dB above it.", True
    inside = float((band_levels(signal)[1] ** 2).sum() / 2) / rms_of(signal) ** 2
    outside = " Most of the signal is outside of that range." if inside < MOSTLY_OUTSIDE else ""
    return unfelt_text(strongest, of="its strongest moment") + outside, False


def strongest_db(signal: Signal) -> float:
    """Return the sensation level of the strongest `MOMENT_S` of a signal over time, dB: pauses do not count."""
    half = max(1, round(MOMENT_S * signal.rate / 2))
    x = np.pad(
        centred(signal), ((0, 0), (half, 2 * half))
    )  # each sample is in the middle of a moment, for its window
    padded = signal.with_samples(x.astype(np.float32))
    return max(
        sensation_level_db(padded.cut(start, start + 2 * half)) for start in range(0, len(signal) + 1, half)
    )


def unfelt_text(level_db: float, *, of: str) -> str:
    """Return the sentence that something with a sensation level below 0 dB is not felt."""
    if not math.isfinite(level_db):
        return f"Cannot be felt: no energy in the range of {FELT_HZ[0]:g} to {FELT_HZ[1]:g} Hz."
    verb = "Cannot" if level_db < -ACCURACY_DB else "May not"
    return (
        f"{verb} be felt: {of} is {-level_db:.0f} dB below the detection threshold (accurate to about "
        f"{ACCURACY_DB:g} dB) in the range of {FELT_HZ[0]:g} to {FELT_HZ[1]:g} Hz."
    )


def envelope(samples: NDArray[np.float32], width: int) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return the positions and values of the minimum and maximum in each of ``width`` pixels.

    Parameters
    ----------
    samples : float32 array, shape (time,)
    width : int
        Pixels.

    Returns
    -------
    place : int64 array, shape (point,)
        Increasing.
    value : float32 array, shape (point,)
        All samples if there are at most two per pixel.
    """
    n = len(samples)
    if n <= 2 * width:
        return np.arange(n), samples
    edges = (np.arange(width) * n) // width
    spans = [slice(a, b) for a, b in zip(edges, [*edges[1:], n], strict=True)]
    places = np.array(
        sorted({s.start + int(f(samples[s])) for s in spans for f in (np.argmin, np.argmax)}), np.int64
    )
    return places, samples[places]


def spectrogram_db(
    signal: Signal,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the level over time and frequency, with the power of all axes summed.

    A sine of amplitude a on a bin has the level 20 log10(a) dB. Hann windows of about 32 ms (over displacement a
    sixteenth of the signal) overlap by three quarters; the mean of each axis is removed.

    Returns
    -------
    frequency : float64 array, shape (frequency,), Hz or cycles per mm
        Up to 1 kHz or half the rate; over displacement half the rate.
    time : float64 array, shape (time,), s or mm
        Middle of each column.
    level : float64 array, shape (frequency, time), dB re 1 unit
        At least -200.
    """
    x = centred(signal)
    width = min(len(signal), max(64, 2 ** round(math.log2(max(2.0, signal.rate * _window_of(signal))))))
    if width < 2:
        x, width = np.pad(x, ((0, 0), (0, 1))), 2
    hop = max(1, width // 4)
    window = scipy.signal.get_window("hann", width) if width > 3 else np.ones(width)
    pad = width // 2
    x = np.pad(x, ((0, 0), (pad, pad + hop)), mode="symmetric")  # a cut to silence would be a click
    starts = np.arange(0, x.shape[1] - width + 1, hop)
    starts = starts[starts <= len(signal)]
    frequency = np.asarray(np.fft.rfftfreq(width, 1 / signal.rate), np.float64)
    kept = frequency <= _top_hz(signal) * (1 + 1e-9)
    frames = np.lib.stride_tricks.sliding_window_view(x, width, axis=1)[:, ::hop]
    power = np.empty((int(kept.sum()), len(starts)))
    some = max(1, AT_ONCE // (width * len(x)))
    for first in range(0, len(starts), some):
        last = min(first + some, len(starts))
        spectra = np.fft.rfft(frames[:, first:last] * window, axis=2)  # axis, time, frequency
        power[:, first:last] = (np.abs(spectra[..., : len(power)]) ** 2).sum(0).T
    power *= (2 / window.sum()) ** 2
    power[0] /= 4  # 0 Hz has no negative counterpart
    return frequency[kept], starts / signal.rate, 10 * np.log10(np.maximum(power, 1e-20))


def band_levels(signal: Signal) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the amplitude of the sine with each third octave's power, all axes summed.

    Noise is felt by its power in a band, and thresholds are those of sines: this puts both on one scale.

    Returns
    -------
    frequency : float64 array, shape (band,)
        Centres within `FELT_HZ` and below half the rate, each band at least one bin wide; over displacement cycles per
        mm, from one per signal length.
    amplitude : float64 array, shape (band,), in the signal's unit
    """
    x = centred(signal)
    n = len(signal)
    power = (np.abs(np.fft.rfft(x, axis=1)) ** 2).sum(0) / n**2
    power[1 : (n + 1) // 2] *= 2
    step = signal.rate / n
    edges = (np.arange(len(power) + 1) - 0.5) * step
    total = np.concatenate([[0.0], np.cumsum(power)])
    ratio = 10 ** (0.5 / BANDS_PER_DECADE)
    narrowest = step / (ratio - 1 / ratio)
    low, high = FELT_HZ if signal.domain == "time" else (narrowest, signal.rate / 2)
    first = math.ceil(BANDS_PER_DECADE * math.log10(max(low * 0.99, narrowest)) - 1e-9)
    last = math.floor(BANDS_PER_DECADE * math.log10(min(high * 1.01, signal.rate / 2 / ratio)) + 1e-9)
    middle = 10 ** (np.arange(first, last + 1) / BANDS_PER_DECADE)
    band = np.interp(middle * ratio, edges, total) - np.interp(middle / ratio, edges, total)
    return middle, np.sqrt(2 * np.maximum(band, 0))


def centred(signal: Signal) -> NDArray[np.float64]:
    """Return the samples with the mean of each axis removed, float64, shape (axis, time)."""
    x = signal.samples.astype(np.float64)
    x -= x.mean(axis=1, keepdims=True)
    return x


def _top_hz(signal: Signal | SignalTraits) -> float:
    half = signal.rate / 2
    return min(half, FELT_HZ[1]) if signal.domain == "time" else half


def _window_of(signal: Signal) -> float:
    """Return the length of a spectrogram's window, s or mm."""
    return 0.032 if signal.domain == "time" else signal.extent / 16
