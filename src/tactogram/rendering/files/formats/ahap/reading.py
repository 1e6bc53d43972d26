"""Reader of AHAP: a pattern's events, with the parameters and curves that act on them.

Core Haptics sets missing entries to defaults, clamps values and ignores keys that it does not know (Apple), and so does
this reader, which names each case.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from tactogram.rendering.files.documents import DecodedDocument, Node, in_order
from tactogram.rendering.files.events import (
    JUMP_S,
    Events,
    FrequencySpan,
    Line,
    Part,
    Transient,
    densified,
    increasing,
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
    for one in event.nodes("EventParameters", optional=True):
        if (name := one.text("ParameterID")) in known:
            if name == "Sustained" and isinstance(switch := one.value.get("ParameterValue"), bool):
                one.value["ParameterValue"] = int(switch)
            values[name] = one.number("ParameterValue", None, 0.0, 1.0, name=name)
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
    at = both[(both >= times[0]) & (both <= times[-1])]
    last = times[-1] - JUMP_S  # A step of a control at its end does not act on it.

    def amplitude(t: Line) -> Line:
        control = _at(controls[INTENSITY], np.minimum(t, last))
        return np.asarray((values["HapticIntensity"] * control * np.interp(t, times, gain)) ** 2)

    # The square of a line is none.
    dense = densified(at)
    at = np.union1d(at, dense[thinned(dense, amplitude(dense), FINE)])
    sharp = np.clip(values["HapticSharpness"] + _at(controls[SHARPNESS], np.minimum(at, last)), 0, 1)
    return Part(at, amplitude(at), SPAN.hz(sharp))


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
            points = [(start + one.number("Time", 0.0, 0.0), _value(one, name)) for one in nodes]
        elif step.text("ParameterID") == name:
            points = [(step.number("Time", 0.0), _value(step, name))]
        pieces += [in_order(points, curve.notes, "control points")] if points else []
    times, values = np.array([-1.0]), np.array([1.0 if name == INTENSITY else 0.0])
    for piece in sorted(pieces, key=lambda piece: piece[0][0]):
        at, new = np.array(piece).T
        before = at[0] - JUMP_S
        kept = times < before
        held = np.interp(before, times, values)
        times = increasing(np.concatenate([times[kept], [before], at]))
        values = np.concatenate([values[kept], [held], new])
    return times, values


def _value(node: Node, name: str) -> float:
    return node.number("ParameterValue", None, *CONTROLS[name], name=name)
