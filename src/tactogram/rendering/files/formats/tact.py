"""``.tact``, bHaptics Designer's patterns: the strength of a vest's motors every 20 ms.

The vendor publishes no schema. Members and their meaning are those that its own SDK reads (bhaptics/haptic-library,
whose samples also hold the frames that the Designer rendered from them) and those of the patterns that it and others
publish (haptic-guide, bhaptics-popone-support, bHapticsLib). A frame every 20 ms takes each motor's strength at its
time, in hundredths; fades are linear. The file names positions and motors, and no frequency.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.control_points import StepRules
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key
from tactogram.rendering.files.events import Events, Line, Part, Transient, joined

FRAME_MS = 20
LEVELS = 100
POSITION = "VestFront"
"""Where a signal is written: all motors of the front of a vest, the most common device. A choice."""
COLUMNS, ROWS = (0, 0.333, 0.667, 1), (0, 0.25, 0.5, 0.75, 1)
"""Places of the 20 motors of either side of a vest, in the order of their numbers."""
MOTOR_HZ = 170.0
"""Assumed when a file is read, as for phones. A choice."""
STEPS = StepRules(step_ms=FRAME_MS, pulse_ms=0, gap_ms=0, tap_ms=0, levels=LEVELS)
_FADES = {"NONE": [1], "FADE_IN": [0, 1], "FADE_OUT": [1, 0], "FADE_IN_OUT": [0, 1, 0]}
"""Shares of the strength at equal times."""
_FADE_POINTS = 101
_LAYOUT = [
    {"index": len(COLUMNS) * row + column, "x": x, "y": y}
    for row, y in enumerate(ROWS)
    for column, x in enumerate(COLUMNS)
]


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1.

    All motors of `POSITION` do the same: vibrations in one track, whose steps change between frames, so that each frame
    falls into one of them, and transients in another, each an effect of one frame.
    """
    edges, strength = STEPS.write(events, what="a bHaptics pattern", first_ms=FRAME_MS // 2)
    steps = zip(edges[:-1].tolist(), edges[1:].tolist(), strength.tolist(), strict=True)
    taps = [
        _effect(start, FRAME_MS, [_dot(0, FRAME_MS, round(LEVELS * share) / LEVELS)])
        for start, share in STEPS.taps(events)
    ]
    length = max([int(edges[-1]), *(tap["startTime"] + FRAME_MS for tap in taps)])
    tracks = [[_effect(0, length, [_dot(*step) for step in steps])], *([taps] if taps else [])]
    project = {
        "createdAt": 0,
        "description": header.description,
        "layout": {
            "layouts": dict.fromkeys(("VestBack", POSITION), _LAYOUT),
            "name": "Tactot",
            "type": "Tactot",
        },
        "mediaFileDuration": length / 1e3,
        "name": "tactogram",
        "tracks": [{"effects": effects, "enable": True} for effects in tracks],
        "updatedAt": 0,
    }
    return {"project": project, "durationMillis": length, "intervalMillis": FRAME_MS, "size": 20}


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document: the strongest motor at any time, at `MOTOR_HZ`.

    A path is as strong as its points and the lines between them. A dot of one frame, away from others, is a transient.
    """
    notes, project = document.notes, document.node("project")
    layouts = project.node("layout", optional=True).node("layouts", optional=True)
    known = {name: {node.value.get("index") for node in layouts.nodes(name)} for name in layouts.value}
    parts: list[Part] = []
    taps: dict[float, float] = {}
    seconds = 0.0
    tracks = (track for track in project.nodes("tracks") if track.value.get("enable", True))
    for effect in (entry for track in tracks for entry in track.nodes("effects")):
        start, length = effect.number("startTime", None, 0.0), effect.number("offsetTime", None, 0.0)
        seconds, modes = max(seconds, (start + length) / 1e3), effect.node("modes")
        for position in modes.value:
            if position not in known:
                notes.warn(f"position must be one of {', '.join(known)}", position, "played all the same")
            mode = modes.node(position)
            dotted = mode.text("mode") != "PATH_MODE"
            lines = _lines(mode, dotted, known.get(position), length)
            for times, values in lines:
                near = [dot for dot, _ in lines if times[0] - 1 <= dot[-1] and dot[0] <= times[-1] + 1]
                inside = np.clip(times, 0, length)
                times_s = (start + inside) / 1e3
                if dotted and len(near) == 1 and times[-1] - times[0] <= FRAME_MS and np.ptp(values) == 0:
                    taps[times_s[0]] = max(taps.get(times_s[0], 0.0), float(values[0]))
                elif inside[-1] > inside[0]:
                    parts.append(Part.of(times_s, np.interp(inside, times, values), 0.0, MOTOR_HZ))
    if seconds < 1e-3:
        notes.problems.append("the pattern holds no effect of 1 ms or more")
    notes.check()
    transients = (Transient(float(time), share, MOTOR_HZ) for time, share in taps.items())
    whole = [joined(parts, strongest=True)] if parts else []
    events = Events.of(whole, transients, seconds)
    return DecodedDocument(
        events, project.text("description"), "nothing in the file: a choice", "which motors"
    )


def _dot(start: int, end: int, share: float) -> dict[str, Any]:
    points = [{"index": motor["index"], "intensity": float(share)} for motor in _LAYOUT] if share > 0 else []
    return {"startTime": start, "endTime": end, "playbackType": "NONE", "pointList": points}


def _effect(start: int, length: int, dots: list[dict[str, Any]]) -> dict[str, Any]:
    path = {"movingPattern": "CONST_SPEED", "playbackType": "NONE", "visible": True, "pointList": []}
    modes = {
        name: {
            "dotMode": {"dotConnected": False, "feedback": own},
            "mode": "DOT_MODE",
            "pathMode": {"feedback": [path]},
        }
        for name, own in (("VestBack", []), (POSITION, dots))
    }
    return {"modes": modes, "name": "Effect 1", "offsetTime": length, "startTime": start}


def _lines(mode: Node, dotted: bool, motors: set[Any] | None, length: float) -> list[tuple[Line, Line]]:
    """Return times (ms) and strength of each feedback of the mode in use, with its fade."""
    lines = []
    for feedback in mode.node("dotMode" if dotted else "pathMode").nodes("feedback"):
        points = _dotted(feedback, motors) if dotted else _path(feedback, length)
        if not points:
            continue
        times, strength = np.array(points).T
        if (playback := feedback.text("playbackType", "NONE")) not in _FADES:
            feedback.notes.warn(f"playbackType must be one of {', '.join(_FADES)}", playback, "read as NONE")
        elif playback != "NONE":
            fine = np.linspace(times[0], times[-1], _FADE_POINTS)
            fade = np.interp(fine, np.linspace(times[0], times[-1], len(_FADES[playback])), _FADES[playback])
            times, strength = fine, np.interp(fine, times, strength) * fade
        lines.append((times, strength))
    return lines


def _dotted(feedback: Node, motors: set[Any] | None) -> list[tuple[float, float]]:
    """Return times (ms) and strength of the strongest motor, at its start and its end."""
    start, end = feedback.number("startTime", None, 0.0), feedback.number("endTime", None, 0.0)
    strength = 0.0
    for dot in feedback.nodes("pointList"):
        strength = max(strength, dot.number("intensity", None, 0.0, 1.0))
        if motors is not None and (index := dot.number("index")) not in motors:
            dot.notes.warn("a dot must be at a motor of the layout", f"{index:g}", "played all the same")
    if end < start:
        feedback.notes.warn("endTime must be at least startTime", f"{end:g} and {start:g}", "left out")
    return [(start, strength), (end, strength)] if strength > 0 and end >= start else []


def _path(feedback: Node, length: float) -> list[tuple[float, float]]:
    """Return times (ms) and strength of a path's points; a single point stays until the end of the effect."""
    points = sorted(
        (point.number("time", None, 0.0), point.number("intensity", None, 0.0, 1.0))
        for point in feedback.nodes("pointList")
    )
    return [*points, (max(length, points[0][0]), points[0][1])] if len(points) == 1 else points


FORMAT = HapticFormat(
    name="tact",
    engine="bHaptics vests",
    title="bHaptics pattern",
    suffix=".tact",
    holds="envelope",
    encode=encode,
    decode=decode,
    resolution_s=FRAME_MS / 1e3,
    recognise=has_key("project"),
)
