"""Fit report: what was scaled and clipped, what the display cannot reach, and levels by octave."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from tactogram.signal.signal import Signal

SENTENCES = ("scaled", "clipped", "unreachable")
"""Keys of a family's facts that hold sentences."""
Array = NDArray[np.float64]
OCTAVES_HZ = (16.0, 31.5, 63.0, 125.0, 250.0, 500.0, 1000.0, 2000.0)
"""Centres, IEC 61260's nominal ones: from below the lowest felt vibration to above the highest."""


@dataclass(frozen=True)
class FitReport:
    """Report of `fit`; every value is JSON.

    ``level`` is the requested one (`Level.facts`); ``signal`` and ``drive`` have unit, rate, axes, duration, peak and
    rms (`signal_facts`). Sentences: every factor that was applied, and why (``scaled``), what was cut at a limit
    (``clipped``), and what of the signal this display cannot render (``unreachable``); ``facts`` are the numbers behind
    them, by family.
    """

    display: str
    family: str
    level: Mapping[str, Any]
    signal: Mapping[str, Any]
    drive: Mapping[str, Any]
    scaled: Sequence[str] = ()
    clipped: Sequence[str] = ()
    unreachable: Sequence[str] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Return JSON values.

        Raises `ValueError` or `TypeError` if a family's facts contain something else, NaN for instance: a defect.
        """
        values = {name: getattr(self, name) for name in type(self).__dataclass_fields__}
        plain: dict[str, Any] = json.loads(json.dumps(values, allow_nan=False))
        return plain

    def as_text(self) -> str:
        """Return lines of text."""
        lines = [
            f"{self.display} ({self.family}), level {self.level['asked']}",
            f"signal: {_in_words(self.signal)}",
            f"drive: {_in_words(self.drive)}",
        ]
        for name in SENTENCES:
            sentences = getattr(self, name)
            lines += [f"{name}: {sentence}" for sentence in sentences] or [f"{name}: nothing"]
        return "\n".join(lines)


def signal_facts(signal: Signal) -> dict[str, Any]:
    """Return unit, rate, axes, extent, peak and rms of a signal over time or displacement, as JSON values."""
    x = signal.samples.astype(np.float64)
    return {
        "unit": signal.unit,
        "rate": signal.rate,
        "domain": signal.domain,
        "axes": list(signal.axes),
        "extent": signal.extent,
        "peak": float(np.abs(x).max()),
        "rms": float(np.sqrt(np.mean(x**2))),
    }


def amount(value: float, unit: str) -> str:
    """Return ``value`` with its unit, if any, as text."""
    return f"{value:.4g}" if unit == "1" else f"{value:.4g} {unit}"


def percent(share: float) -> str:
    """Return a share as text with two digits: ``100 %``, ``4.2 %``, ``0.031 %``."""
    return f"{float(f'{100 * share:.2g}'):g} %"


def _in_words(facts: Mapping[str, Any]) -> str:
    over = "s" if facts["domain"] == "time" else "mm"
    per = "Hz" if facts["domain"] == "time" else "per mm"
    return (
        f"{', '.join(facts['axes'])}; {facts['extent']:.4g} {over} at {facts['rate']:g} {per}; "
        f"peak {amount(facts['peak'], facts['unit'])}, rms {amount(facts['rms'], facts['unit'])}"
    )


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
