"""Android 16's envelope with frequency: the calls of `VibrationEffect.WaveformEnvelopeBuilder` as JSON.

``initialFrequencyHz`` is of ``setInitialFrequencyHz``, each entry of ``controlPoints`` of a call of
``addControlPoint(amplitude, frequencyHz, durationMillis)``. An amplitude of 1 is the strongest that the phone can do.
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from tactogram.rendering.files.control_points import (
    MOST_POINTS,
    ControlPoints,
    Milliseconds,
    Share,
    control_points,
    has_points,
)
from tactogram.rendering.files.documents import (
    DecodedDocument,
    DocumentHeader,
    DocumentPart,
    problems_of,
)
from tactogram.rendering.files.envelope import carrier
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

TITLE = "Android waveform envelope (API 36)"

Hertz = Annotated[float, Field(gt=0)]


class Point(DocumentPart):
    """A call of addControlPoint."""

    amplitude: Share
    hz: Hertz = Field(alias="frequencyHz")
    ms: Milliseconds = Field(alias="durationMillis")


class WaveformEnvelope(DocumentPart):
    """A complete file."""

    format: Literal["android-waveform-envelope"] = "android-waveform-envelope"
    start_hz: Hertz | None = Field(None, alias="initialFrequencyHz")
    points: tuple[Point, ...] = Field(
        alias="controlPoints", min_length=1, max_length=MOST_POINTS, strict=False
    )
    description: str = ""


validate = partial(problems_of, WaveformEnvelope)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1."""
    found = control_points(signal, what=TITLE)
    return {
        "format": "android-waveform-envelope",
        "initialFrequencyHz": round(found.start_hz, 1),
        "controlPoints": [
            {
                "amplitude": round(float(amplitude), 4),
                "frequencyHz": round(float(hz), 1),
                "durationMillis": int(ms),
            }
            for amplitude, hz, ms in zip(found.amplitude, found.hz, found.ms, strict=True)
        ],
        "description": header.description,
    }


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the signal of a valid document, as a carrier at ``rate``."""
    read = WaveformEnvelope.model_validate(document)
    points = ControlPoints(
        read.start_hz or read.points[0].hz,
        np.array([point.ms for point in read.points]),
        np.array([point.amplitude for point in read.points]),
        np.array([point.hz for point in read.points]),
    )
    low, high = float(points.hz.min()), float(points.hz.max())
    facts = {"carrier_hz": [low, high], "carrier_from": "frequencyHz"}
    envelope = points.envelope()
    return DecodedDocument(carrier(envelope, rate), read.description, facts, envelope)


FORMAT = HapticFormat(
    name="android_envelope",
    title=TITLE,
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_points("frequencyHz"),
    instead="android (a strength every 10 ms, at the phone's own frequency)",
)
