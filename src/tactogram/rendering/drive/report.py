"""Fit report: what was scaled, what was clipped, and what the display cannot reach."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tactogram.signal.signal import Signal

SENTENCES = ("scaled", "clipped", "unreachable")
"""Keys of a family's facts that hold sentences."""


@dataclass(frozen=True)
class FitReport:
    """Report of `fit`; every value is JSON.

    Parameters
    ----------
    display, family : str
    level : mapping
        The requested level, see `Level.facts`.
    signal, drive : mapping
        Unit, rate, axes, duration, peak and rms of the input and of the drive.
    scaled : sequence of str
        Every factor that was applied, and why.
    clipped : sequence of str
        What was cut at a limit.
    unreachable : sequence of str
        What this display cannot render of the signal.
    facts : mapping
        The numbers behind them, by family.
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
