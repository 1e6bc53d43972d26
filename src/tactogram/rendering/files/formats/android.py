"""Android's vibration waveform: `VibrationEffect.createWaveform(timings, amplitudes, repeat)` as JSON.

``timings`` in integral ms, ``amplitudes`` 0 to 255, of equal length; ``repeat`` is -1 or the index from which to
repeat. Steps of 10 ms, as in Meta's exporter. A phone states neither its frequency nor the strength of 255.
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
from tactogram.rendering.files.envelope import (
    HIGHEST_HZ,
    PHONE_HZ,
    carrier,
    stepped_envelope,
    stepped_strength,
)
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

STEP_MS = 10
STRONGEST = 255
LONGEST_MS = 24 * 3600 * 1000


class Waveform(DocumentPart):
    """A complete file."""

    format: Literal["android-waveform"] = "android-waveform"
    timings: tuple[Annotated[int, Field(ge=0, le=LONGEST_MS)], ...] = Field(
        min_length=1, max_length=MOST_ENTRIES, strict=False
    )
    amplitudes: tuple[Annotated[int, Field(ge=0, le=STRONGEST)], ...] = Field(
        min_length=1, max_length=MOST_ENTRIES, strict=False
    )
    repeat: int = -1
    description: str = ""

    @model_validator(mode="after")
    def _consistent(self) -> Waveform:
        if len(self.timings) != len(self.amplitudes):
            raise ValueError(
                f"timings and amplitudes must be equally many, got {len(self.timings)} and {len(self.amplitudes)}"
            )
        if not any(self.timings):
            raise ValueError("at least one timing must be above 0 ms")
        if not -1 <= self.repeat < len(self.timings):
            raise ValueError(f"repeat must be -1 or an entry's number, got {self.repeat}")
        return self


validate = partial(problems_of, Waveform)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1."""
    edges, (strength,) = stepped_strength(signal, STEP_MS, [(0.0, HIGHEST_HZ)], what="an Android waveform")
    strength = np.rint(STRONGEST * strength)
    first = np.flatnonzero(np.diff(strength, prepend=-1))
    return {
        "format": "android-waveform",
        "timings": [int(ms) for ms in np.diff(np.append(edges[first], edges[-1]))],
        "amplitudes": [int(a) for a in strength[first]],
        "repeat": -1,
        "description": header.description,
    }


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return one playback of a valid document, as a carrier of `PHONE_HZ` at ``rate``."""
    waveform = Waveform.model_validate(document)
    edges = np.concatenate([[0], np.cumsum(waveform.timings)]) / 1e3
    strength = np.array(waveform.amplitudes) / STRONGEST
    envelope = stepped_envelope(edges, strength, PHONE_HZ)
    facts: dict[str, Any] = {
        "carrier_hz": [PHONE_HZ],
        "carrier_from": "nothing in the file: a phone's usual",
    }
    if waveform.repeat >= 0:
        facts["left_out"] = f"repetition from entry {waveform.repeat}"
    return DecodedDocument(carrier(envelope, rate), waveform.description, facts, envelope)


FORMAT = HapticFormat(
    name="android",
    title="Android waveform",
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_key("timings"),
    instead="the phone's envelope (android_envelope, from Android 16)",
)
