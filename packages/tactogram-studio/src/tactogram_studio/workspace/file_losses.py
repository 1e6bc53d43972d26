"""Losses of haptic files: a row for each, and strengths over time of the signal and of what the files hold."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering import (
    GRAVITY,
    envelope_of,
    haptic_format,
    read_haptic,
    to_one_axis,
    without_constant,
)
from tactogram.signal import Signal, played

MOST_POINTS = 500
Curve = list[tuple[float, float]]
"""Times, s, and strengths in the signal's unit."""


def losses_table(files: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row per format (and axis): ``format``, ``axis``, ``bytes`` and the fields of `Loss`, or ``refused``."""
    rows: list[dict[str, Any]] = []
    for name, facts in files.items():
        if "refused" in facts:
            rows.append({"format": name, "axis": "", "refused": facts["refused"]})
            continue
        written = facts["written"]
        loss = written["loss"]
        by_axis = loss if isinstance(next(iter(loss.values()), None), Mapping) else {"": loss}
        rows += [
            {"format": name, "axis": axis, "bytes": written["bytes"], **values}
            for axis, values in by_axis.items()
        ]
    return rows


def loss_text(row: Mapping[str, Any], key: str) -> str:
    """Return one loss for people; "none" where a file has no waveform to compare."""
    value = row[key]
    if key in ("waveform_correlation", "snr_db") and haptic_format(row["format"]).holds != "waveform":
        return "none"
    if value is None:
        return "none"
    return f"{value:.0f}" if key == "snr_db" else f"{value + 0.0:.3f}".replace("-0.000", "0.000")


def strength_curves(
    signal: Signal, folder: Path, files: Mapping[str, Any], *, axis: str, play_at: float | None
) -> dict[str, Curve]:
    """Return the strength over time of a signal and of each file, read back with its level, by name."""
    if signal.domain != "time":
        if play_at is None:
            raise ParameterError("the strength over time of a signal over displacement needs a speed")
        signal = played(signal, play_at, signal.rate * play_at)
    one, _ = to_one_axis(without_constant(signal, least=GRAVITY)[0], axis or None)
    curves = {"signal": _curve(one)}
    for name, facts in files.items():
        if "file" in facts:
            stored = read_haptic(folder / facts["file"], format=name).signal
            if stored.domain == "time":
                curves[haptic_format(name).title] = _curve(to_one_axis(stored, None)[0])
    return curves


def _curve(signal: Signal) -> Curve:
    envelope = envelope_of(signal)
    count = min(MOST_POINTS, len(envelope.times))
    places = np.unique(np.linspace(0, len(envelope.times) - 1, count).astype(int))
    strengths = [float(f"{value:.4g}") for value in envelope.amplitude[places]]
    return list(zip((round(float(t), 4) for t in envelope.times[places]), strengths, strict=True))
