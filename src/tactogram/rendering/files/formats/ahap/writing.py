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
"""Intensity, and ten times as much sharpness, by which a steady vibration varies at most."""
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
    runs = [_shares(run, span) for part in events.parts for run in part.runs]
    controls = _controls(runs, np.array([one.time for one in events.transients]))
    entries = [entry for run in runs for entry in _continuous(run, controls)]
    entries += [
        _event(
            one.time, "HapticTransient", math.sqrt(min(1.0, one.amplitude)), float(span.share(one.frequency))
        )
        for one in events.transients
    ]
    starts = np.array(sorted(entry["Event"]["Time"] for entry in entries))
    for t, level, sharp in controls:
        end = round(float(t[-1]), _DIGITS)
        # In the silence before the next event, so that it is not heard.
        rest = [round((end + start) / 2, _DIGITS) for start in starts[starts >= end][:1].tolist()]
        curves = ((INTENSITY, level, INTENSITY_STEP, 1.0), (SHARPNESS, sharp, SHARPNESS_STEP, 0.0))
        for name, values, tolerance, idle in curves:
            chosen = thinned(t, values, tolerance)
            entries += _curves(name, t[chosen], values[chosen])
            step = {"ParameterID": name, "ParameterValue": idle}
            entries += [{"Parameter": step | {"Time": time}} for time in rest]
    return {
        "Version": 1.0,
        "Metadata": {"Project": "tactogram", "Description": header.description},
        "Pattern": sorted(
            entries or _chunks(0.0, events.seconds, 0.0, 0.0),
            key=lambda entry: float(next(iter(entry.values()))["Time"]),
        ),
    }


def _shares(run: Part, span: FrequencySpan) -> Part:
    """Return a vibration of intensity and sharpness, with more points: the root of a line is not a line."""
    t = densified(run.times)
    return Part(t, np.sqrt(np.minimum(run.at(t), 1)), span.share(run.hz(t)))


def _controls(runs: list[Part], taps: Line) -> list[tuple[Line, Line, Line]]:
    """Return times, intensity and sharpness of the controls: of vibrations that are not steady, beside transients."""
    varying = [run for run in runs if np.ptp(run.amplitude) > STEADY or np.ptp(run.frequency) > 10 * STEADY]
    spans = np.array(sorted((run.start, run.end) for run in varying)).reshape(-1, 2)
    windows = spans_of(np.maximum(0, taps - LEAD_S), taps + PULSE_S, 3 * LEAD_S)
    found = []
    for first, last in spans_of(spans[:, 0], np.maximum.accumulate(spans[:, 1]), 0.0):
        near = [edge for window in windows if window[0] < last and window[1] > first for edge in window]
        edges = [first, *near, last]
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            inside = [run for run in runs if run.start < end and run.end > start]
            if end - start > LEAD_S:
                t = np.unique(np.concatenate([run.within(start, end).times for run in inside]))
                sharp = [np.where((t < run.start) | (t > run.end), 1.0, run.hz(t)) for run in inside]
                found.append((t, np.max([run.at(t) for run in inside], axis=0), np.min(sharp, axis=0)))
    return found


def _continuous(run: Part, controls: list[tuple[Line, Line, Line]]) -> list[dict[str, Any]]:
    """Return a vibration as continuous events, each of the intensity and sharpness that the controls lack."""
    edges = {edge for t, _, _ in controls for edge in (t[0], t[-1]) if run.start < edge < run.end}
    pieces: list[list[float]] = []
    tolerances = np.array([PIECE_STEP, SHARPNESS_STEP])
    for start, end in pairwise(sorted({run.start, run.end, *edges})):
        acting = next((one for one in controls if one[0][0] <= start and end <= one[0][-1]), None)
        t = run.within(start, end).times
        if acting:
            t = np.union1d(t, acting[0][slice(*np.searchsorted(acting[0], [start, end]))])
        own, sharp = run.at(t), run.hz(t)
        if acting:
            level, base = (np.interp(t, acting[0], values) for values in acting[1:])
            heard = level > INTENSITY_STEP
            own = np.interp(t, t[heard], own[heard] / level[heard]) if heard.any() else np.ones(len(t))
            sharp = sharp - base
        kept = np.union1d(thinned(t, own, PIECE_STEP), thinned(t, sharp, SHARPNESS_STEP))
        for i, j in pairwise(kept.tolist()):
            steps = (np.abs([own[j] - own[i], sharp[j] - sharp[i]]) / tolerances).max() / 2
            count = max(1, min(math.ceil(steps), int((t[j] - t[i]) / LEAD_S)))
            ends = np.linspace(t[i], t[j], 1 + count).tolist() if t[j] - t[i] > 2 * JUMP_S else []
            for a, b in pairwise(ends):
                found = [float(np.interp((a + b) / 2, t, values)) for values in (own, sharp)]
                if pieces and (np.abs(np.subtract(pieces[-1][2:], found)) <= tolerances / 2).all():
                    pieces[-1][1] = b
                else:
                    pieces.append([pieces[-1][1] if pieces else a, b, *found])
    return [entry for piece in pieces for entry in _chunks(*piece)]


def _chunks(start: float, end: float, intensity: float, sharpness: float) -> list[dict[str, Any]]:
    """Return a continuous event, or several where it is longer than Core Haptics plays."""
    return [
        _event(at, "HapticContinuous", intensity, sharpness, duration=min(LONGEST_EVENT_S, end - at))
        for at in np.arange(start, end, LONGEST_EVENT_S).tolist()
        if end - at >= SHORTEST_S
    ]


def _event(
    time: float, kind: str, intensity: float, sharpness: float, *, duration: float | None = None
) -> dict[str, Any]:
    values = {"HapticIntensity": intensity, "HapticSharpness": sharpness}
    parameters = [{"ParameterID": name, "ParameterValue": round(value, 4)} for name, value in values.items()]
    event: dict[str, Any] = {
        "Time": round(float(time), _DIGITS),
        "EventType": kind,
        "EventParameters": parameters,
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
