"""AHAP, Apple's haptic patterns (Core Haptics): vibrations, transients, and the curves that act on both.

"Representing haptic patterns in AHAP files", Apple developer documentation. As in Meta's exporter (haptic_data, MIT),
intensity is the square root of the amplitude. Events that overlap play together; their powers are added. Core Haptics
sets missing entries to defaults, clamps values and ignores keys that it does not know (Apple), and so does the reader,
which names each case.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key, in_order
from tactogram.rendering.files.events import (
    JUMP_S,
    PULSE_S,
    SHORTEST_S,
    Events,
    FrequencySpan,
    Line,
    Part,
    Transient,
    densified,
    increasing,
    spans_of,
    thinned,
)

SPAN = FrequencySpan(65.0, 300.0)
"""Sharpness 0 and 1, Hz: AhapEncoder of the MPEG haptics reference software. Apple names no frequency."""
LONGEST_EVENT_S = 30.0
"""Longest continuous event that Core Haptics plays (CHHapticEvent)."""
SHORTEST_DECAY_S = 0.02
"""Decay of an event that is not sustained and states no decay: Apple states no time. A choice."""
FINE = 5e-4
"""Largest deviation of the lines of a vibration from the square of its intensity."""
INTENSITY, SHARPNESS = "HapticIntensityControl", "HapticSharpnessControl"
TIMES = ("AttackTime", "DecayTime", "ReleaseTime")
DEFAULTS = {"HapticIntensity": 1.0, "HapticSharpness": 0.5} | dict.fromkeys(TIMES, 0.0) | {"Sustained": 1.0}
CONTROLS = {INTENSITY: (0.0, 1.0), SHARPNESS: (-1.0, 1.0)}
"""Parameters of all events over time (CHHapticDynamicParameter.ID), and their ranges. Those of attack, decay and
release change times by factors that Apple does not state: they are left out."""

Control = tuple[Line, Line]


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document: each continuous event a vibration of its own, with what the curves make of it.

    Intensity is multiplied by its control, sharpness added to (CHHapticDynamicParameter), of transients too; a control
    holds after its last point. AttackTime, DecayTime and ReleaseTime are read as s: Apple calls them 0 to 1, of which
    "higher values increase the time exponentially" (CHHapticParameter.h).
    """
    notes, left_out = document.notes, Counter[str]()
    entries = list(_entries(document.nodes("Pattern")))
    controls = {name: _control(entries, name) for name in CONTROLS}
    parts, taps, last = [], [], 0.0
    for event in (entry.node("Event") for entry in entries if entry.has("Event")):
        kind, start = event.text("EventType"), event.number("Time", 0.0, 0.0)
        if start < last:
            notes.warn("events must be in order of time", done="sorted")
        last = start
        if kind not in ("HapticContinuous", "HapticTransient"):
            left_out[f"{kind or 'untyped'} events"] += 1
            continue
        values = _values(
            event, left_out, known=DEFAULTS if kind == "HapticContinuous" else list(DEFAULTS)[:2]
        )
        if kind == "HapticTransient":
            strength = values["HapticIntensity"] * float(_at(controls[INTENSITY], start))
            sharp = float(np.clip(values["HapticSharpness"] + _at(controls[SHARPNESS], start), 0, 1))
            taps.append(Transient(start, strength**2, float(SPAN.hz(sharp))))
        elif duration := event.number("EventDuration", None, 0.0, LONGEST_EVENT_S):
            parts.append(_vibration(start, duration, values, controls))
            if values["AttackTime"] or values["ReleaseTime"] or values["Sustained"] < 0.5:
                done = f"read as s, a decay as {SHORTEST_DECAY_S:g} s at least"
                notes.warn(f"Apple states no unit of {', '.join(TIMES)}", done=done)
        elif event.has("EventDuration"):
            notes.warn("EventDuration of a HapticContinuous event must be above 0 s", done="left out")
    for entry in entries:
        key = next((key for key in ("ParameterCurve", "Parameter", "Event") if entry.has(key)), "")
        if not key:
            left_out[f"entries of {', '.join(sorted(map(str, entry.value))[:3]) or 'nothing'}"] += 1
        elif key != "Event" and not (name := (own := entry.node(key)).text("ParameterID")):
            own.notes.warn(f"a {key} must have a ParameterID", done="left out")
        elif key != "Event" and name not in CONTROLS:
            left_out[name] += 1
    if not parts and not taps and not notes.problems:
        notes.problems.append("Pattern: holds no haptic event")
    notes.check()
    events = Events.of(parts, taps, max([0.0, *(part.end for part in parts)]), SPAN)
    about = document.value.get("Metadata")
    text = str(about.get("Description") or "") if isinstance(about, dict) else ""
    gone = ", ".join(f"{count} {name}" for name, count in left_out.items())
    return DecodedDocument(events, text, "sharpness", gone)


def _entries(entries: list[Node]) -> Iterator[Node]:
    """Yield the entries of a pattern, and those of patterns nested in it."""
    for entry in entries:
        if entry.has("Pattern"):
            yield from _entries(entry.nodes("Pattern"))
        else:
            yield entry


def _values(event: Node, left_out: Counter[str], known: dict[str, float] | list[str]) -> dict[str, float]:
    """Return an event's parameters, those that it lacks by their defaults."""
    values = dict(DEFAULTS)
    for parameter in event.nodes("EventParameters", optional=True):
        if (name := parameter.text("ParameterID")) in known:
            if name == "Sustained" and isinstance(switch := parameter.value.get("ParameterValue"), bool):
                parameter.value["ParameterValue"] = int(switch)
            values[name] = parameter.number("ParameterValue", None, 0.0, 1.0, name=name)
        else:
            left_out[name or "unnamed parameters"] += 1
    return values


def _vibration(start: float, duration: float, values: dict[str, float], controls: dict[str, Control]) -> Part:
    """Return a continuous event: it rises within the attack, and falls within the release after its duration.

    If it is not sustained, it falls within the decay after the attack; if it is, the decay has no effect (Apple).
    """
    attack, decay, release = (values[name] for name in TIMES)
    points = [(0.0, 0.0), (attack, 1.0)] if attack else [(0.0, 1.0)]
    if values["Sustained"] < 0.5:
        points.append((attack + max(decay, SHORTEST_DECAY_S), 0.0))
    times, gain = np.array(points).T
    left = float(np.interp(duration, times, gain))
    times, gain = np.append(times[times < duration], duration), np.append(gain[times < duration], left)
    if release and left:
        times, gain = np.append(times, duration + release), np.append(gain, 0.0)
    times = start + times
    both = np.unique(np.concatenate([times, controls[INTENSITY][0], controls[SHARPNESS][0]]))
    instants = both[(both >= times[0]) & (both <= times[-1])]
    last = times[-1] - JUMP_S  # A step of a control at its end does not act on it.

    def amplitude(t: Line) -> Line:
        control = _at(controls[INTENSITY], np.minimum(t, last))
        return np.asarray((values["HapticIntensity"] * control * np.interp(t, times, gain)) ** 2)

    # The square of a line is none.
    dense = densified(instants)
    instants = np.union1d(instants, dense[thinned(dense, amplitude(dense), FINE)])
    sharp = np.clip(values["HapticSharpness"] + _at(controls[SHARPNESS], np.minimum(instants, last)), 0, 1)
    return Part(instants, amplitude(instants), SPAN.hz(sharp))


def _at(control: Control, t: Line | float) -> Line:
    return np.asarray(np.interp(t, *control))


def _control(entries: list[Node], name: str) -> Control:
    """Return times and values of a control; a later curve takes over from an earlier one."""
    pieces: list[list[tuple[float, ...]]] = []
    for entry in entries:
        curve, step = (entry.node(kind, optional=True) for kind in ("ParameterCurve", "Parameter"))
        points: list[tuple[float, ...]] = []
        if curve.text("ParameterID") == name:
            start, nodes = curve.number("Time", 0.0), curve.nodes("ParameterCurveControlPoints")
            points = [(start + node.number("Time", 0.0, 0.0), _value(node, name)) for node in nodes]
        elif step.text("ParameterID") == name:
            points = [(step.number("Time", 0.0), _value(step, name))]
        pieces += [in_order(points, curve.notes, "control points")] if points else []
    times, values = np.array([-1.0]), np.array([1.0 if name == INTENSITY else 0.0])
    for piece in sorted(pieces, key=lambda piece: piece[0][0]):
        new_times, new = np.array(piece).T
        before = new_times[0] - JUMP_S
        kept = times < before
        held = np.interp(before, times, values)
        times = increasing(np.concatenate([times[kept], [before], new_times]))
        values = np.concatenate([values[kept], [held], new])
    return times, values


def _value(node: Node, name: str) -> float:
    return node.number("ParameterValue", None, *CONTROLS[name], name=name)


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
    controls = _controls(runs, np.array([tap.time for tap in events.transients]))
    entries = [entry for run in runs for entry in _continuous(run, controls)]
    entries += [
        _event(
            tap.time, "HapticTransient", math.sqrt(min(1.0, tap.amplitude)), float(span.share(tap.frequency))
        )
        for tap in events.transients
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
    controls = []
    for first, last in spans_of(spans[:, 0], np.maximum.accumulate(spans[:, 1]), 0.0):
        near = [edge for window in windows if window[0] < last and window[1] > first for edge in window]
        edges = [first, *near, last]
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            inside = [run for run in runs if run.start < end and run.end > start]
            if end - start > LEAD_S:
                t = np.unique(np.concatenate([run.within(start, end).times for run in inside]))
                sharp = [np.where((t < run.start) | (t > run.end), 1.0, run.hz(t)) for run in inside]
                controls.append((t, np.max([run.at(t) for run in inside], axis=0), np.min(sharp, axis=0)))
    return controls


def _continuous(run: Part, controls: list[tuple[Line, Line, Line]]) -> list[dict[str, Any]]:
    """Return a vibration as continuous events, each of the intensity and sharpness that the controls lack."""
    edges = {edge for t, _, _ in controls for edge in (t[0], t[-1]) if run.start < edge < run.end}
    pieces: list[list[float]] = []
    tolerances = np.array([PIECE_STEP, SHARPNESS_STEP])
    for start, end in pairwise(sorted({run.start, run.end, *edges})):
        acting = next((curve for curve in controls if curve[0][0] <= start and end <= curve[0][-1]), None)
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
                middle = [float(np.interp((a + b) / 2, t, values)) for values in (own, sharp)]
                if pieces and (np.abs(np.subtract(pieces[-1][2:], middle)) <= tolerances / 2).all():
                    pieces[-1][1] = b
                else:
                    pieces.append([pieces[-1][1] if pieces else a, b, *middle])
    return [entry for piece in pieces for entry in _chunks(*piece)]


def _chunks(start: float, end: float, intensity: float, sharpness: float) -> list[dict[str, Any]]:
    """Return a continuous event, or several where it is longer than Core Haptics plays."""
    return [
        _event(begin, "HapticContinuous", intensity, sharpness, duration=min(LONGEST_EVENT_S, end - begin))
        for begin in np.arange(start, end, LONGEST_EVENT_S).tolist()
        if end - begin >= SHORTEST_S
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


FORMAT = HapticFormat(
    name="ahap",
    engine="iOS",
    title="AHAP (Apple)",
    suffix=".ahap",
    holds="envelope",
    encode=encode,
    decode=decode,
    recognise=has_key("Pattern"),
    commas_at_ends=True,  # Apple's own samples have them (Apple.CoreHaptics of its Unity plug-ins: Open, Spin, …)
)
