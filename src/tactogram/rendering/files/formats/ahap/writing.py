"""Writer of AHAP: vibrations become continuous events, with the curves that control them, and transients."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from tactogram.rendering.files.documents import DocumentHeader
from tactogram.rendering.files.events import (
    JUMP_S,
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
PIECE_STEP = 0.04
"""Largest deviation of an event's intensity from that of the vibration, where no curve follows it."""
STEADY = 1e-4
"""Intensity and sharpness by which a vibration of one event varies at most, in squares."""
LEAD_S = 0.001
"""Time before a transient from which the controls do nothing, s."""
_DIGITS = 6


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1.

    A vibration is an event, or several where its intensity or sharpness varies in another way than the controls, which
    act on all events at once: intensity is the strongest vibration's, sharpness the lowest one. They are 1 and 0
    where only steady vibrations sound, and around each transient.
    """
    events.check_length("AHAP")
    span = events.span or SPAN
    runs = [run for part in events.parts for run in part.runs]
    entries = [
        _event(one.time, "HapticTransient", one.amplitude, float(span.share(one.frequency)))
        for one in events.transients
    ]
    controlled = _controlled(runs, events, span)
    for run in runs:
        entries += _continuous(run, runs, controlled, span)
    last = max((float(entry["Event"]["Time"]) for entry in entries), default=0.0)
    for start, end in controlled:
        inside, t = _between(start, end, runs)
        level, sharp = _controls(t, inside, span)
        curves = ((INTENSITY, level, INTENSITY_STEP, 1.0), (SHARPNESS, sharp, SHARPNESS_STEP, 0.0))
        for name, values, tolerance, idle in curves:
            chosen = thinned(t, values, tolerance)
            entries += _curves(name, t[chosen], values[chosen])
            if end <= last:
                step = {"ParameterID": name, "Time": round(end, _DIGITS), "ParameterValue": idle}
                entries.append({"Parameter": step})
    return {
        "Version": 1.0,
        "Metadata": {"Project": "tactogram", "Description": header.description},
        "Pattern": sorted(
            entries or _chunks(0.0, events.seconds, 0.0, 0.0),
            key=lambda entry: float(next(iter(entry.values()))["Time"]),
        ),
    }


def _controlled(runs: list[Part], events: Events, span: FrequencySpan) -> list[tuple[float, float]]:
    """Return the times in which controls act: those of vibrations that are not steady, without the transients."""
    spans = sorted(
        (run.start, run.end)
        for run in runs
        if np.ptp(run.amplitude) > STEADY or np.ptp(span.share(run.frequency)) > 10 * STEADY
    )
    if not spans:
        return []
    starts, ends = np.array(spans).T
    taps = np.array([one.time for one in events.transients])
    windows = spans_of(np.maximum(0, taps - LEAD_S), taps + PULSE_S, 3 * LEAD_S)
    found = []
    for start, end in spans_of(starts, np.maximum.accumulate(ends), 0.0):
        near = [window for window in windows if window[0] < end and window[1] > start]
        edges = [start, *(edge for window in near for edge in window), end]
        found += [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > LEAD_S]
    return found


def _between(start: float, end: float, runs: list[Part]) -> tuple[list[Part], Line]:
    """Return the vibrations between two times, and the times of their points there, with more on curves."""
    inside = [run for run in runs if run.start < end and run.end > start]
    at = np.unique([edge for run in inside for edge in (run.start - JUMP_S, *run.times, run.end + JUMP_S)])
    # The root of a line is not a line; a line that leaves the span has a bend there.
    return inside, densified(np.concatenate([[start], at[(at > start) & (at < end)], [end]]))


def _controls(t: Line, runs: list[Part], span: FrequencySpan) -> tuple[Line, Line]:
    """Return the strongest intensity and the lowest sharpness of vibrations at times."""
    sounding = [(t >= run.start) & (t <= run.end) for run in runs]
    shares = [np.where(on, span.share(run.hz(t)), 1.0) for on, run in zip(sounding, runs, strict=True)]
    return _level(np.max([run.at(t) for run in runs], axis=0)), np.min(shares, axis=0)


def _level(amplitude: Line) -> Line:
    return np.asarray(np.sqrt(np.minimum(amplitude, 1)))


def _continuous(
    run: Part, runs: list[Part], controlled: list[tuple[float, float]], span: FrequencySpan
) -> list[dict[str, Any]]:
    """Return a vibration as continuous events, each of the intensity and sharpness that the controls lack."""
    edges = [edge for window in controlled for edge in window if run.start < edge < run.end]
    pieces: list[list[float]] = []
    tolerances = np.array([PIECE_STEP, SHARPNESS_STEP])
    for start, end in pairwise([run.start, *edges, run.end]):
        inside, t = _between(start, end, runs)
        own, sharp = _level(run.at(t)), span.share(run.hz(t))
        if any(first <= start and end <= last for first, last in controlled):
            level, base = _controls(t, inside, span)
            heard = level > INTENSITY_STEP
            own = np.interp(t, t[heard], own[heard] / level[heard]) if heard.any() else np.ones(len(t))
            sharp = sharp - base
        kept = np.union1d(thinned(t, own, PIECE_STEP), thinned(t, sharp, SHARPNESS_STEP))
        for i, j in pairwise(kept.tolist()):
            if t[j] - t[i] <= 2 * JUMP_S:
                continue
            steps = (np.abs([own[j] - own[i], sharp[j] - sharp[i]]) / tolerances).max() / 2
            ends = np.linspace(t[i], t[j], 1 + max(1, min(math.ceil(steps), int((t[j] - t[i]) / LEAD_S))))
            for a, b in pairwise(ends.tolist()):
                found = [float(np.interp((a + b) / 2, t, values)) for values in (own, sharp)]
                if pieces and (np.abs(np.subtract(pieces[-1][2:], found)) <= tolerances / 2).all():
                    pieces[-1][1] = b
                else:
                    pieces.append([pieces[-1][1] if pieces else a, b, *found])
    return [entry for start, end, level, sharp in pieces for entry in _chunks(start, end, level**2, sharp)]


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
