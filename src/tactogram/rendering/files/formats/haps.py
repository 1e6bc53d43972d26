"""``.haps`` version 5, Interhaptics' effects: amplitude, frequency in Hz, transients.

The vendor publishes no schema. Members, units and which of them may be missing are those of effects that it ships:
Interhaptics' Unity and Unreal SDKs, Razer's WYVRN SDK and its Sensa development kit. ReaHaptic, an exporter by others,
writes the same. Times are in s and, within a note, relative to its start. Keyframes are joined by lines: no source says
what the engine does between them, nor how it combines melodies, whose powers are added here. Version 6, without ``m_``
in its names, is not read.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key
from tactogram.rendering.files.events import (
    JUMP_S,
    UNKNOWN_HZ,
    Events,
    Line,
    Part,
    Transient,
    bends,
    increasing,
    joined,
    voices,
)

AMPLITUDE_STEP, FREQUENCY_STEP_HZ = 0.005, 2.0
"""Largest deviation of the file's lines from the vibration."""
TRANSIENT_S = 0.022
"""Length of a transient in the vendor's files, s."""
_DIGITS = 6


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1: a melody of transients, and one for each overlapping vibration."""
    events.check_length("an Interhaptics effect")
    melodies = voices(events.parts)
    if not events.count:
        melodies = [[Part.of([0.0, events.seconds], [0.0, 0.0], 0.0, UNKNOWN_HZ)]]
    taps = [
        _note(tap.time, TRANSIENT_S, min(1.0, tap.amplitude), {"m_type": 0}, priority=0)
        for tap in events.transients
    ]
    return {
        "m_version": "5",
        "m_description": header.description,
        "m_HDFlag": 0,
        "m_time_unit": 0,
        "m_length_unit": 7,
        "m_stiffness": _perception(),
        "m_texture": _perception(),
        "m_vibration": _perception(taps, *([_vibration(part) for part in melody] for melody in melodies)),
        "m_gain": 1.0,
    }


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document. A transient has the frequency of the vibration at its time, if there is one."""
    notes = document.notes
    version = next((document.value[key] for key in ("m_version", "version") if document.has(key)), None)
    if str(version) not in ("5", "5.0") or not document.has("m_version"):
        notes.problems.append(f"version must be 5 (m_version), got {version!r}; export it as version 5")
        notes.check()
    vibration = document.node("m_vibration")
    level = document.number("m_gain", 1.0, 0.0) * vibration.number("m_gain", 1.0, 0.0)
    parts: list[Part] = []
    taps: list[tuple[float, float, Line]] = []
    for melody in vibration.nodes("m_melodies"):
        gain = level * melody.number("m_gain", 1.0, 0.0)
        lasting = []
        for note in melody.nodes("m_notes"):
            start, length = note.number("m_startingPoint", None, 0.0), note.number("m_length", None, 0.0)
            strength, effect = gain * note.number("m_gain", None, 0.0), note.node("m_hapticEffect")
            amplitude = _keyframes(effect, "m_amplitudeModulation")
            tones = _keyframes(effect, "m_frequencyModulation")
            if melody.value.get("m_mute"):
                continue
            if len(amplitude):
                lasting.append((start, length, strength, amplitude, tones))
            else:
                taps.append((start, min(1.0, strength), tones))
        # A vibration ends where the next one of its melody begins, at the latest.
        lasting.sort(key=lambda note: note[0])
        following = [*(note[0] for note in lasting[1:]), np.inf]
        for played, after in zip(lasting, following, strict=False):
            if (end := played[0] + played[1]) > after + 10 * JUMP_S:
                rule = "notes of a melody must not overlap"
                notes.warn(rule, f"{end:g} s and {after:g} s", "one ends where the next begins")
            parts.append(_part(*played, after))
    if not parts and not taps:
        notes.problems.append("the file holds no vibration")
    notes.check()
    whole = joined(parts)
    events = Events.of(
        parts,
        (
            Transient(start, share, float(tones[0, 1] if len(tones) else whole.hz(start)))
            for start, share, tones in taps
        ),
        max([0.0, *(part.end for part in parts)]),
    )
    others = (
        name
        for name in ("stiffness", "texture")
        for entry in document.node(f"m_{name}", optional=True).nodes("m_melodies", optional=True)
        if entry.value.get("m_notes")
    )
    source = "m_frequencyModulation" if parts else "nothing in the file: transients have none"
    return DecodedDocument(events, document.text("m_description"), source, ", ".join(dict.fromkeys(others)))


def _keyframes(effect: Node, name: str) -> Line:
    """Return times and values of a modulation, in order, shape (keyframe, 2). Some of the vendor's are out of order."""
    keyframes = effect.node(name, optional=True).nodes("m_keyframes", optional=True)
    both = sorted((key.number("m_time", None, 0.0), key.number("m_value", None, 0.0)) for key in keyframes)
    return np.array(both).reshape(-1, 2)


def _part(start: float, length: float, gain: float, amplitude: Line, tones: Line, after: float) -> Part:
    """Return a note as a vibration; the values of its first and last keyframe hold outside them."""
    end = max(0.0, min(length, after - start))
    times, values = increasing(amplitude[:, 0]), amplitude[:, 1]
    instants = np.union1d(times, [0.0, end])
    instants = instants[instants <= end]
    turns, hz = tones.T if len(tones) else ([0.0], [UNKNOWN_HZ])
    return Part.of(start + instants, gain * np.interp(instants, times, values), start + np.asarray(turns), hz)


def _note(
    start: float, seconds: float, gain: float, effect: dict[str, Any], *, priority: int
) -> dict[str, Any]:
    return {
        "m_startingPoint": round(start, _DIGITS),
        "m_length": round(seconds, _DIGITS),
        "m_priority": priority,
        "m_gain": round(gain, 4),
        "m_hapticEffect": effect,
    }


def _vibration(part: Part) -> dict[str, Any]:
    modulations = (
        ("m_amplitudeModulation", np.minimum(part.amplitude, 1), AMPLITUDE_STEP, 4),
        ("m_frequencyModulation", part.frequency, FREQUENCY_STEP_HZ, 1),
    )
    effect = {
        name: {
            "m_extrapolationStrategy": 0,
            "m_keyframes": [
                {"m_time": round(time, _DIGITS), "m_value": round(value, digits)}
                for time, value in bends(part.times - part.start, values, tolerance)
            ],
        }
        for name, values, tolerance, digits in modulations
    }
    return _note(part.start, part.end - part.start, 1.0, effect, priority=1)


def _perception(*melodies: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "m_loop": 0,
        "m_maximum": 1.0,
        "m_gain": 1.0,
        "m_signalEvaluationMethod": 3,
        "m_melodies": [{"m_mute": 0, "m_gain": 1.0, "m_notes": notes} for notes in melodies],
    }


FORMAT = HapticFormat(
    name="haps",
    engine="Unity and Unreal, with Interhaptics or WYVRN",
    title="Interhaptics effect v5",
    suffix=".haps",
    holds="envelope",
    encode=encode,
    decode=decode,
    recognise=has_key("m_vibration"),
)
