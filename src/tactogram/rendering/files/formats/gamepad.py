"""Gamepad rumble (W3C Gamepad Extensions): a sequence of `playEffect("dual-rumble", effect)` as JSON.

``startDelay`` and ``duration`` in ms, magnitudes 0 to 1 of a strong slow motor and a weak fast one. Chromium refuses
effects whose delay and duration together exceed 5000 ms (kMaxEffectDurationMillis), so a long signal is a sequence:
wait for each effect's promise before playing the next.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from tactogram.rendering.files.documents import (
    MOST_ENTRIES,
    DecodedDocument,
    DocumentHeader,
    DocumentPart,
    has_key,
    problems_of,
)
from tactogram.rendering.files.envelope import HIGHEST_HZ, carrier, stepped_envelope, stepped_strength
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

LONGEST_MS = 5000
STEP_MS = 50
"""An eccentric motor cannot follow anything faster. A choice."""
SPLIT_HZ = 100.0
"""Lower frequencies drive the strong motor, higher ones the weak one. A choice: the specification names none."""
STRONG_HZ, WEAK_HZ = 60.0, 160.0
"""Assumed when a file is read. A choice."""
MAGNITUDES = 100
"""Steps of a magnitude: finer ones are not felt, and equal neighbours are merged."""

Milliseconds = Annotated[float, Field(ge=0)]
Magnitude = Annotated[float, Field(ge=0, le=1)]


class Effect(DocumentPart):
    """A call of playEffect."""

    delay: Milliseconds = Field(0.0, alias="startDelay")
    duration: Milliseconds
    strong: Magnitude = Field(0.0, alias="strongMagnitude")
    weak: Magnitude = Field(0.0, alias="weakMagnitude")

    @model_validator(mode="after")
    def _short(self) -> Effect:
        if self.delay + self.duration > LONGEST_MS:
            raise ValueError(
                f"startDelay and duration must be at most {LONGEST_MS} ms together, "
                f"got {self.delay + self.duration:g}; split it"
            )
        return self


class Sequence(DocumentPart):
    """A complete file."""

    format: Literal["gamepad-effects"] = "gamepad-effects"
    type: Literal["dual-rumble"]
    effects: tuple[Effect, ...] = Field(min_length=1, max_length=MOST_ENTRIES, strict=False)
    description: str = ""

    @model_validator(mode="after")
    def _lasts(self) -> Sequence:
        if not any(effect.duration > 0 for effect in self.effects):
            raise ValueError("at least one effect must last longer than 0 ms")
        return self


validate = partial(problems_of, Sequence)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1."""
    bands = ((0.0, SPLIT_HZ), (SPLIT_HZ, HIGHEST_HZ))
    edges, strengths = stepped_strength(signal, STEP_MS, bands, what="a gamepad effect")
    motors = [np.rint(MAGNITUDES * strength) / MAGNITUDES for strength in strengths]
    effects: list[dict[str, Any]] = []
    for ms, strong, weak in zip(np.diff(edges), *motors, strict=True):
        last = effects[-1] if effects else None
        same = last is not None and (last["strongMagnitude"], last["weakMagnitude"]) == (strong, weak)
        if same and last is not None and last["duration"] + ms <= LONGEST_MS:
            last["duration"] += int(ms)
            continue
        effects.append(
            {
                "startDelay": 0,
                "duration": int(ms),
                "strongMagnitude": float(strong),
                "weakMagnitude": float(weak),
            }
        )
    return {
        "format": "gamepad-effects",
        "type": "dual-rumble",
        "effects": effects,
        "description": header.description,
    }


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the signal of a valid document, as two carriers of `STRONG_HZ` and `WEAK_HZ` at ``rate``."""
    sequence = Sequence.model_validate(document)
    spans = [ms for effect in sequence.effects for ms in (effect.delay, effect.duration)]
    edges = np.concatenate([[0], np.cumsum(spans)]) / 1e3
    strong = np.array([m for effect in sequence.effects for m in (0.0, effect.strong)])
    weak = np.array([m for effect in sequence.effects for m in (0.0, effect.weak)])
    slow = carrier(stepped_envelope(edges, strong, STRONG_HZ), rate)
    fast = carrier(stepped_envelope(edges, weak, WEAK_HZ), rate)
    facts = {"carrier_hz": [STRONG_HZ, WEAK_HZ], "carrier_from": "nothing in the file: two motors' usual"}
    return DecodedDocument(slow.with_samples(slow.samples + fast.samples), sequence.description, facts)


FORMAT = HapticFormat(
    name="gamepad",
    title="Gamepad effects",
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_key("effects"),
    instead="a pad's sound channels (display dualsense), or .haptic",
)
