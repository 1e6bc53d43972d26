"""Android 16's envelope with sharpness: the calls of `VibrationEffect.BasicEnvelopeBuilder` as JSON.

``initialSharpness`` is of ``setInitialSharpness``, each entry of ``controlPoints`` of a call of
``addControlPoint(intensity, sharpness, durationMillis)``; the last intensity is 0. Each phone turns intensity and
sharpness into its own amplitudes and frequencies, in a way that the file does not state.
"""

from __future__ import annotations

from functools import partial
from typing import Any, Literal

import numpy as np
from pydantic import Field, model_validator

from tactogram.rendering.files.control_points import (
    MOST_POINTS,
    ControlPoints,
    Milliseconds,
    Share,
    control_points,
    has_points,
)
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, DocumentPart, problems_of
from tactogram.rendering.files.envelope import FrequencySpan, carrier
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

TITLE = "Android basic envelope (API 36)"
SPAN = FrequencySpan(65.0, 300.0)
"""Frequencies that sharpness is taken for, and intensity for amplitude. A choice: those of AHAP's sharpness."""


class Point(DocumentPart):
    """A call of addControlPoint."""

    intensity: Share
    sharpness: Share
    ms: Milliseconds = Field(alias="durationMillis")


class BasicEnvelope(DocumentPart):
    """A complete file."""

    format: Literal["android-basic-envelope"] = "android-basic-envelope"
    start_sharpness: Share | None = Field(None, alias="initialSharpness")
    points: tuple[Point, ...] = Field(
        alias="controlPoints", min_length=1, max_length=MOST_POINTS, strict=False
    )
    description: str = ""

    @model_validator(mode="after")
    def _ends_at_rest(self) -> BasicEnvelope:
        if self.points[-1].intensity != 0:
            raise ValueError(
                f"the last control point must have an intensity of 0, got {self.points[-1].intensity:g}"
            )
        return self


validate = partial(problems_of, BasicEnvelope)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1."""
    found = control_points(signal, what=TITLE)
    sharpness = SPAN.share(found.hz)
    return {
        "format": "android-basic-envelope",
        "initialSharpness": round(float(SPAN.share(found.start_hz)), 4),
        "controlPoints": [
            {
                "intensity": round(float(one), 4),
                "sharpness": round(float(sharp), 4),
                "durationMillis": int(ms),
            }
            for one, sharp, ms in zip(found.amplitude, sharpness, found.ms, strict=True)
        ],
        "description": header.description,
    }


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the signal of a valid document, as a carrier at ``rate``."""
    read = BasicEnvelope.model_validate(document)
    start = read.points[0].sharpness if read.start_sharpness is None else read.start_sharpness
    points = ControlPoints(
        float(SPAN.hz(start)),
        np.array([point.ms for point in read.points]),
        np.array([point.intensity for point in read.points]),
        SPAN.hz(np.array([point.sharpness for point in read.points])),
    )
    facts = {"carrier_hz": [SPAN.low, SPAN.high], "carrier_from": "sharpness"}
    envelope = points.envelope()
    return DecodedDocument(carrier(envelope, rate), read.description, facts, envelope)


FORMAT = HapticFormat(
    name="android_basic",
    title=TITLE,
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_points("sharpness"),
    instead="android (faster changes) or android_envelope (any frequency)",
)
