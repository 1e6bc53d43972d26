"""Android's vibration waveform: `VibrationEffect.createWaveform(timings, amplitudes, repeat)` as JSON.

``timings`` in integral ms, ``amplitudes`` 0 to 255, of equal length; ``repeat`` is -1 or the index from which to
repeat. Steps of 10 ms, as in Meta's exporter. A phone states neither its frequency nor the strength of 255. Without
amplitudes the timings are off, on, off …, and an amplitude of -1 is the phone's default, as in the function.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.control_points import TAP_MS, StepRules
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key
from tactogram.rendering.files.events import FROM_PHONE, PHONE_HZ, Events

STRONGEST = 255
LONGEST_MS = 24 * 3600 * 1000
STEPS = StepRules(step_ms=10, pulse_ms=15, gap_ms=5, tap_ms=TAP_MS, levels=STRONGEST)
"""A transient of 15 ms: a phone's actuator needs about that to start, and it is no multiple of a step. A choice."""


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1."""
    edges, strength = STEPS.write(events, what="an Android waveform")
    return {
        "format": "android-waveform",
        "timings": [int(ms) for ms in np.diff(edges)],
        "amplitudes": [round(STRONGEST * share) for share in strength.tolist()],
        "repeat": -1,
        "description": header.description,
    }


def decode(document: Node) -> DecodedDocument:
    """Return one playback of a document, at `PHONE_HZ`."""
    notes = document.notes
    timings = document.numbers("timings", 0, LONGEST_MS)
    if timings and not any(timings):
        notes.problems.append("timings: at least one must be above 0 ms")
    if broken := [ms for ms in timings if ms % 1]:
        notes.warn("timings must be whole ms", f"{broken[0]:g}")
    strength = [float(i % 2) for i in range(len(timings))]
    if document.has("amplitudes"):
        stated = [STRONGEST if raw == -1 else raw for raw in document.numbers("amplitudes", -1, STRONGEST)]
        strength = [value / STRONGEST for value in stated]
    if len(strength) != len(timings):
        rule = "timings and amplitudes must be equally many"
        notes.problems.append(f"{rule}, got {len(timings)} and {len(strength)}")
    elif not timings:
        notes.problems.append("timings: must not be empty")
    repeat = int(document.number("repeat", -1, -1, max(0, len(timings) - 1)))
    notes.check()
    events = STEPS.read(np.append(0.0, np.cumsum(timings)) / 1e3, np.array(strength), PHONE_HZ)
    left_out = f"repetition from entry {repeat}" if repeat >= 0 else ""
    return DecodedDocument(events, document.text("description"), FROM_PHONE, left_out)


FORMAT = HapticFormat(
    name="android",
    engine="Android",
    title="Android waveform",
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    recognise=has_key("timings"),
    instead={"the phone's envelope (android_envelope, from Android 16)": "android_envelope"},
)
