"""Equaliser of a stream for a display's response: causal, minimum phase, with known errors.

A whole file is divided by the response in one spectrum, within the display's band and with a cap
(`rendering.displays.response.inverse`). A stream has only the past. Its equaliser has the same magnitude and, of all
causal filters with that magnitude, the least delay: recursive edges at the ends of the band, and in between a
transversal filter just long enough to come within `WITHIN_DB` of the file's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import signal as dsp

from tactogram.errors import ParameterError
from tactogram.signal.filters import minimum_phase

Array = NDArray[np.float64]
Gain = Callable[[Array], Array]
"""Magnitude at frequencies in Hz."""

WITHIN_DB = 0.25
"""A filter is long enough if its error nowhere in the band exceeds this."""
LONGEST_S = 0.25
"""Length of the longest transversal filter: it resolves 4 Hz from 8 Hz."""
SHORTEST_TAPS, MOST_TAPS = 64, 4096
"""In powers of two; 4,096 taps over a block of 5 ms need one transform of some 8,000 points."""
EDGE_ORDER, EDGE_RIPPLE_DB = 4, 0.5
"""Chebyshev edges: -0.5 dB where the band ends, -30 dB an octave outside."""
HIGHEST_EDGE = 0.45
"""An upper edge above this share of the rate is omitted, for lack of room."""
REFERENCE_HZ = 250.0
"""Frequency at which the delay is reported, Hz: the most sensitive frequency of touch."""
GRID = 1 << 15
DEEPEST_DB = 80.0


@dataclass(frozen=True, eq=False)
class EqualiserDesign:
    """Filter for a stream at ``rate`` in the display's ``band`` (Hz), and its difference from the wanted magnitude.

    ``taps`` are minimum phase, shape (tap,); ``edges`` second-order sections of the band's edges, shape (section, 6),
    none if the band ends with the rate. Its magnitude is compared with ``wanted`` in ``checked`` (Hz), since a file's
    edges may lie within the band.
    """

    rate: float
    band: tuple[float, float]
    taps: Array
    edges: Array
    wanted: Gain
    checked: tuple[float, float]

    def response(self, frequency: Array) -> NDArray[np.complex128]:
        """Return the frequency response at ``frequency`` in Hz, complex128, of the same shape."""
        z = 2 * np.pi * np.asarray(frequency, np.float64) / self.rate
        _, h = dsp.freqz(self.taps, worN=z.ravel())
        if len(self.edges):
            h = h * dsp.freqz_sos(self.edges, worN=z.ravel())[1]
        return np.asarray(h, np.complex128).reshape(z.shape)

    def delay_samples(self, frequency: Array) -> Array:
        """Return the group delay at ``frequency`` in Hz, samples, of the same shape; negative for a lead."""
        low, high = self.response(np.multiply.outer([0.995, 1.005], frequency))
        turn = 2 * np.pi * 0.01 * np.asarray(frequency) / self.rate
        return np.asarray(-np.angle(high / low) / turn)

    @cached_property
    def checked_hz(self) -> Array:
        """Frequencies of ``checked`` at every 24th of an octave, Hz, float64, shape (frequency,)."""
        low = max(self.checked[0], self.rate / GRID, 1.0)
        high = max(min(self.checked[1], HIGHEST_EDGE * self.rate), 1.001 * low)
        return np.geomspace(low, high, max(2, math.ceil(24 * math.log2(high / low))))

    @cached_property
    def errors_db(self) -> Array:
        """Magnitude relative to the wanted one at `checked_hz`, dB, float64, shape (frequency,)."""
        magnitude = np.abs(self.response(self.checked_hz))
        return np.asarray(20 * np.log10(np.maximum(magnitude, 1e-30) / self.wanted(self.checked_hz)))

    def facts(self) -> dict[str, Any]:
        """Return length, delay and errors as JSON values."""
        f, errors = self.checked_hz, self.errors_db
        worst = int(np.abs(errors).argmax())
        reference = min(max(REFERENCE_HZ, f[0]), f[-1])
        delay = float(self.delay_samples(np.array(reference)))
        size = np.abs(self.response(f))
        return {
            "taps": len(self.taps),
            "delay_samples": delay,
            "delay_ms": 1e3 * delay / self.rate,
            "reference_hz": reference,
            "raised_db": float(20 * np.log10(size.max() / size.min())),
            "checked_hz": [float(f[0]), float(f[-1])],
            "error_rms_db": float(np.sqrt(np.mean(errors**2))),
            "error_most_db": float(abs(errors[worst])),
            "error_most_hz": float(f[worst]),
        }


def equaliser(
    rate: float, band: tuple[float, float], wanted: Gain, *, checked: tuple[float, float] | None = None
) -> EqualiserDesign:
    """Return the shortest filter within `WITHIN_DB` of ``wanted`` in the band, or the longest allowed.

    Nothing is wanted outside ``band`` (Hz); 0 and half the rate are no edges. ``wanted`` is evaluated within the band
    only and held outside, since a steep edge in the transversal filter would make it long, with a long delay inside.
    Errors count in ``checked`` (Hz), the band by default. Raises `ParameterError` if nothing of the band lies below
    half the rate, or ``wanted`` is not > 0 and finite there.
    """
    low, high = max(0.0, band[0]), min(band[1], rate / 2)
    if not low < high:
        raise ParameterError(f"a band of {band[0]:g} to {band[1]:g} Hz does not fit a rate of {rate:g} Hz")
    edges = _edges(rate, low, high)
    frequency = np.fft.rfftfreq(GRID, 1 / rate)
    inside = np.clip(frequency, max(low, frequency[1]), min(high, HIGHEST_EDGE * rate))
    gain = np.asarray(wanted(inside), np.float64)
    if not (np.isfinite(gain).all() and gain.min() > 0):
        raise ParameterError("an equaliser's magnitude must be finite and > 0 in the whole band")
    if len(edges):  # compensate for the edges' attenuation inside the band
        gain = gain / np.abs(dsp.freqz_sos(edges, worN=2 * np.pi * inside / rate)[1])
    most = max(SHORTEST_TAPS, min(MOST_TAPS, int(LONGEST_S * rate)))
    impulse, count = _impulse(gain), SHORTEST_TAPS
    while True:
        design = EqualiserDesign(rate, (low, high), _cut(impulse, count), edges, wanted, checked or band)
        if count >= most or float(np.abs(design.errors_db).max()) <= WITHIN_DB:
            return design
        count = min(2 * count, most)


class Equaliser:
    """An `EqualiserDesign` with state. The result depends on the cut into blocks only by rounding."""

    def __init__(self, design: EqualiserDesign) -> None:
        self.design = design
        self._tail: Array | None = None
        self._state: Array | None = None

    def process(self, block: NDArray[np.floating]) -> Array:
        """Return the next block, float64, shape (axis, time) as ``block``; the filter starts at rest."""
        x = np.asarray(block, np.float64)
        count, taps = x.shape[1], self.design.taps
        if self._tail is None or self._state is None:
            self._tail = np.zeros((len(x), len(taps) - 1))
            self._state = np.zeros((len(self.design.edges), len(x), 2))
        # Overlap-add: the tail of this block is added to the next ones.
        whole = dsp.fftconvolve(x, taps[None], axes=1)
        whole[:, : self._tail.shape[1]] += self._tail
        out, self._tail = whole[:, :count], whole[:, count:]
        if len(self.design.edges):
            out, self._state = dsp.sosfilt(self.design.edges, out, axis=1, zi=self._state)
        return np.asarray(out)


def _impulse(gain: Array) -> Array:
    floor = gain.max() * 10 ** (-DEEPEST_DB / 20)
    return minimum_phase(np.log(np.maximum(gain, floor)))


def _cut(impulse: Array, taps: int) -> Array:
    cut = impulse[:taps].copy()
    fade = taps // 4
    if fade:
        cut[-fade:] *= np.cos(np.pi / 2 * np.arange(fade) / fade)
    return cut


def _edges(rate: float, low: float, high: float) -> Array:
    """Return second-order sections for the ends of a band that lie within the rate's range."""
    parts = []
    if low > 0:
        parts.append(dsp.cheby1(EDGE_ORDER, EDGE_RIPPLE_DB, low, "highpass", output="sos", fs=rate))
    if high < HIGHEST_EDGE * rate:
        parts.append(dsp.cheby1(EDGE_ORDER, EDGE_RIPPLE_DB, high, "lowpass", output="sos", fs=rate))
    return np.concatenate(parts) if parts else np.zeros((0, 6))
