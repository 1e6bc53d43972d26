"""Gamepad rumble (W3C Gamepad Extensions): a sequence of `playEffect("dual-rumble", effect)` as JSON.

``startDelay`` and ``duration`` in ms, magnitudes 0 to 1 of a strong slow motor and a weak fast one. Chromium refuses
effects whose delay and duration together exceed 5000 ms (kMaxEffectDurationMillis), so a long signal is a sequence:
wait for each effect's promise before playing the next.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tactogram.rendering.files.analysis import HIGHEST_HZ
from tactogram.rendering.files.catalogue import HapticFormat
from tactogram.rendering.files.control_points import TAP_MS, StepRules
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node, has_key
from tactogram.rendering.files.events import Events

LONGEST_MS = 5000
SPLIT_HZ = 100.0
"""Lower frequencies drive the strong motor, higher ones the weak one. A choice: the specification names none."""
STRONG_HZ, WEAK_HZ = 60.0, 160.0
"""Assumed when a file is read. A choice."""
STEPS = StepRules(step_ms=50, pulse_ms=40, gap_ms=10, tap_ms=TAP_MS, levels=100, least_ms=40)
"""An eccentric motor follows nothing faster than 50 ms, nor starts in much less than 40 ms. Choices."""


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1."""
    motors = []
    for strong in (True, False):
        parts = tuple(
            replace(part, amplitude=np.where((part.frequency <= SPLIT_HZ) == strong, part.amplitude, 0.0))
            for part in events.parts
        )
        taps = tuple(tap for tap in events.transients if (tap.frequency <= SPLIT_HZ) == strong)
        motors.append(STEPS.write(Events(events.seconds, parts, taps), what="a gamepad effect"))
    edges = np.union1d(motors[0][0], motors[1][0])
    magnitudes = [
        np.append(strength, 0.0)[np.searchsorted(own, edges[:-1], side="right") - 1]
        for own, strength in motors
    ]
    effects = [
        {
            "startDelay": 0,
            "duration": int(min(LONGEST_MS, end - begin)),
            "strongMagnitude": float(strong),
            "weakMagnitude": float(weak),
        }
        for start, end, strong, weak in zip(edges[:-1], edges[1:], *magnitudes, strict=True)
        for begin in range(int(start), int(end), LONGEST_MS)
    ]
    about = {"format": "gamepad-effects", "type": "dual-rumble"}
    return about | {"effects": effects, "description": header.description}


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document, of `STRONG_HZ` and `WEAK_HZ`."""
    notes = document.notes
    if bare := _bare(document.value):
        document = Node({"effects": bare}, notes)
    if document.text("type", "dual-rumble") != "dual-rumble":
        notes.warn("type must be dual-rumble", document.value["type"], "read as one")
    spans, values = [], []
    for effect in document.nodes("effects"):
        delay, duration = effect.number("startDelay", 0.0, 0.0), effect.number("duration", None, 0.0)
        if delay + duration > LONGEST_MS:
            rule = f"startDelay and duration must be at most {LONGEST_MS} ms together"
            notes.warn(rule, f"{delay + duration:g}", "Chromium refuses it")
        spans += [delay, duration]
        motors = [effect.number(f"{name}Magnitude", 0.0, 0.0, 1.0) for name in ("strong", "weak")]
        values += [[0.0, 0.0], motors]
    if not any(spans[1::2]):
        notes.problems.append("effects: at least one effect must last longer than 0 ms")
    notes.check()
    edges = np.append(0.0, np.cumsum(spans)) / 1e3
    strong, weak = (
        STEPS.read(edges, magnitudes, hz)
        for magnitudes, hz in zip(np.array(values).T, (STRONG_HZ, WEAK_HZ), strict=True)
    )
    parts, taps = strong.parts + weak.parts, strong.transients + weak.transients
    events = Events.of(parts, taps, float(edges[-1]), limited=False)
    return DecodedDocument(events, document.text("description"), "nothing in the file: two motors' usual")


def _bare(document: Any) -> list[Any]:
    """Return effects that are no sequence of this package: one, or a list of them."""
    listed = document if isinstance(document, list) else [document]
    return listed if any(map(has_key("duration"), listed)) and not has_key("effects")(document) else []


FORMAT = HapticFormat(
    name="gamepad",
    engine="Godot and the web, on game pads",
    title="Gamepad effects",
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    recognise=lambda document: has_key("effects")(document) or bool(_bare(document)),
    bands=((0.0, SPLIT_HZ), (SPLIT_HZ, HIGHEST_HZ)),
    instead={"a pad's sound channels (display dualsense)": "", ".haptic": "haptic"},
)
