"""Writer of AHAP: vibrations become continuous events, with the curves that control them, and transients."""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.events import (
    PULSE_S,
    SHORTEST_S,
    Events,
    FrequencySpan,
    Line,
    Part,
    densified,
    spans_of,
    thinned,
)
from tactogram.rendering.files.formats.ahap.reading import INTENSITY, LONGEST_EVENT_S, SHARPNESS, SPAN

MOST_POINTS = 16
"""Points of a curve that is written: those of Meta's exporter (haptic_data). Apple states no limit, and curves of
others have hundreds."""
INTENSITY_STEP, SHARPNESS_STEP = 0.01, 0.02
"""Largest deviation of a curve from the vibration."""
STEP_S = 0.001
"""Time in which a curve steps to another value, s."""
STEADY = 1e-4
"""Amplitude, and ten times as much share of the span, by which a steady vibration varies at most."""
_DIGITS = 6


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1.

    Steady vibrations are events with constants of their own, which may overlap. Others are joined, and curves are
    their intensity and sharpness.
    """
    events.check_length("AHAP")
    span = events.span or SPAN
    if all(_steady(part, span) for part in events.parts):
        entries = [
            entry
            for part in events.parts
            for entry in _chunks(part.start, part.end, part.peak, float(span.share(part.frequency.mean())))
        ]
    else:
        entries = _varying(events, span)
    entries += [
        _event(one.time, "HapticTransient", one.amplitude, float(span.share(one.frequency)))
        for one in events.transients
    ]
    return {
        "Version": 1.0,
        "Metadata": {"Project": "tactogram", "Description": header.description},
        "Pattern": sorted(
            entries or _chunks(0.0, events.seconds, 0.0, 0.0),
            key=lambda entry: float(next(iter(entry.values()))["Time"]),
        ),
    }


def _steady(part: Part, span: FrequencySpan) -> bool:
    return bool(np.ptp(part.amplitude) <= STEADY and np.ptp(span.share(part.frequency)) <= 10 * STEADY)


def _varying(events: Events, span: FrequencySpan) -> list[dict[str, Any]]:
    """Return the entries of all vibrations as one.

    Curves act on all events at once, so that they are 1 (intensity) and 0 (sharpness) around each transient, where an
    event of its own is the vibration.
    """
    whole = events.joined.within(0.0, events.seconds)
    # The root of a line is not a line; a line that leaves the span has a bend there.
    t = densified(whole.times)
    level, sharp = np.sqrt(np.minimum(whole.at(t), 1)), span.share(whole.hz(t))
    taps = np.array([one.time for one in events.transients])
    windows = spans_of(np.maximum(0, taps - STEP_S), taps + PULSE_S, 3 * STEP_S)
    entries, last = [], 0.0
    for start, end in [*windows, (events.seconds + STEP_S, events.seconds)]:
        inside = np.linspace(last, start - STEP_S, max(2, int((start - last) / STEP_S)))
        if len(heard := inside[whole.at(inside) > 0]):
            entries += _chunks(
                max(last, heard[0] - STEP_S), min(start - STEP_S, heard[-1] + STEP_S), 1.0, 0.0
            )
        within = np.linspace(start, end, 9)
        if end > start and (own := float(np.mean(np.minimum(whole.at(within), 1)))) > 0:
            entries += _chunks(
                max(0.0, start - STEP_S), end + STEP_S, own, float(span.share(whole.hz(within).mean()))
            )
        last = end + STEP_S
    curves = ((INTENSITY, level, INTENSITY_STEP, 1.0), (SHARPNESS, sharp, SHARPNESS_STEP, 0.0))
    for name, values, tolerance, idle in curves:
        chosen = thinned(t, values, tolerance)
        entries += _curves(name, *_idling(t[chosen], values[chosen], windows, idle))
    return entries


def _idling(times: Line, values: Line, windows: list[tuple[float, float]], idle: float) -> tuple[Line, Line]:
    """Return a line that is ``idle`` within the windows."""
    at = np.array([(start - STEP_S, start, end, end + STEP_S) for start, end in windows]).reshape(-1, 4)
    level = np.interp(at, times, values)
    level[:, 1:3] = idle
    outside = np.searchsorted(at.ravel(), times) % 4 == 0
    both, first = np.unique(np.append(at, times[outside]), return_index=True)
    return both[both >= 0], np.append(level, values[outside])[first][both >= 0]


def _chunks(start: float, end: float, amplitude: float, sharpness: float) -> list[dict[str, Any]]:
    """Return a continuous event, or several where it is longer than Core Haptics plays."""
    return [
        _event(at, "HapticContinuous", amplitude, sharpness, duration=min(LONGEST_EVENT_S, end - at))
        for at in np.arange(start, end, LONGEST_EVENT_S).tolist()
        if end - at >= SHORTEST_S
    ]


def _event(
    time: float, kind: str, amplitude: float, sharpness: float, *, duration: float | None = None
) -> dict[str, Any]:
    values = {"HapticIntensity": float(np.sqrt(min(1.0, amplitude))), "HapticSharpness": sharpness}
    event: dict[str, Any] = {
        "Time": round(float(time), _DIGITS),
        "EventType": kind,
        "EventParameters": [
            {"ParameterID": name, "ParameterValue": round(value, 4)} for name, value in values.items()
        ],
    }
    return {"Event": event | ({} if duration is None else {"EventDuration": round(duration, _DIGITS)})}


def _curves(name: str, times: Line, values: Line) -> list[dict[str, Any]]:
    """Return curves of at most `MOST_POINTS`; each begins where the previous one ended."""
    curves = []
    for first in range(0, max(1, len(times) - 1), MOST_POINTS - 1):
        own = slice(first, first + MOST_POINTS)
        start = round(float(times[first]), _DIGITS)
        points = [
            {"Time": round(max(0.0, time - start), _DIGITS), "ParameterValue": round(value, 4)}
            for time, value in zip(times[own].tolist(), values[own].tolist(), strict=True)
        ]
        curve = {"ParameterID": name, "Time": start, "ParameterCurveControlPoints": points}
        curves.append({"ParameterCurve": curve})
    return curves
