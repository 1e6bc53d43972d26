"""Octave bands of wanted and rendered levels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tactogram.signal.signal import Signal

Array = NDArray[np.float64]

OCTAVES_HZ = (16.0, 31.5, 63.0, 125.0, 250.0, 500.0, 1000.0, 2000.0)
"""Centres, IEC 61260's nominal ones: from below the lowest felt vibration to above the highest."""


def band_table(
    wanted: Signal, rendered: Signal, band: tuple[float, float], *, below: float = np.inf
) -> list[dict[str, Any]]:
    """Return for each octave its centre in Hz, and the wanted and rendered levels, dB re one unit rms.

    None is silence: more than 200 dB below one unit. Power is added over axes. Only octaves that both signals can hold
    and that begin below ``below`` (Hz, half the signal's original rate) are included. ``reachable`` is whether the
    centre lies in ``band`` (Hz).
    """
    powers = [_power(signal) for signal in (wanted, rendered)]
    top = min(wanted.rate / 2, rendered.rate / 2, below)
    return [
        {
            "centre_hz": centre,
            "wanted_db": _level_db(*powers[0], centre),
            "rendered_db": _level_db(*powers[1], centre),
            "reachable": bool(band[0] <= centre <= band[1]),
        }
        for centre in OCTAVES_HZ
        if centre / np.sqrt(2) < top
    ]


def out_of_band_db(signal: Signal, band: tuple[float, float]) -> float:
    """Return the loss of power outside of ``band``, without the mean, dB >= 0."""
    frequency, power = _power(signal)
    total = float(power[1:].sum())
    if total == 0:
        return 0.0
    inside = float(power[1:][(frequency[1:] >= band[0]) & (frequency[1:] <= band[1])].sum())
    return float(-10 * np.log10(max(inside / total, 1e-20)))


def _level_db(frequency: Array, power: Array, centre: float) -> float | None:
    low, high = np.searchsorted(frequency, [centre / np.sqrt(2), centre * np.sqrt(2)])
    inside = float(power[low:high].sum())
    return round(float(10 * np.log10(inside)), 2) if inside > 1e-20 else None


def _power(signal: Signal) -> tuple[Array, Array]:
    """Return frequency in Hz and mean power per bin, summed over axes; its sum is the mean square."""
    n = len(signal)
    x = signal.samples.astype(np.float64)
    power = np.sum(np.abs(fft.rfft(x - x.mean(axis=1, keepdims=True), axis=1)) ** 2, axis=0) / n**2
    power[1 : (n + 1) // 2] *= 2
    return fft.rfftfreq(n, 1 / signal.rate), power
