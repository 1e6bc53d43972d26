"""Android 16's envelope with sharpness: the calls of `VibrationEffect.BasicEnvelopeBuilder` as JSON.

``initialSharpness`` is of ``setInitialSharpness``, each entry of ``controlPoints`` of a call of
``addControlPoint(intensity, sharpness, durationMillis)``; the last intensity is 0. Each phone turns intensity and
sharpness into its own amplitudes and frequencies, in a way that the file does not state.
"""

from __future__ import annotations

from typing import Any

from tactogram.rendering.files.control_points import BANDS, control_points, events_of_points, has_points
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node
from tactogram.rendering.files.events import Events, FrequencySpan
from tactogram.rendering.files.format import HapticFormat

TITLE = "Android basic envelope (API 36)"
SPAN = FrequencySpan(65.0, 300.0)
"""Frequencies that sharpness is taken for, and intensity for amplitude. A choice: those of AHAP's sharpness."""
POINT = ("intensity", "sharpness", "durationMillis")
"""Arguments of a call of addControlPoint."""


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1."""
    points, span = control_points(events, what=TITLE), events.span or SPAN
    return {
        "format": "android-basic-envelope",
        "initialSharpness": round(float(span.share(points.start_hz)), 4),
        "controlPoints": [
            dict(zip(POINT, (round(float(one), 4), round(float(span.share(hz)), 4), int(ms)), strict=True))
            for one, hz, ms in zip(points.amplitude, points.hz, points.ms, strict=True)
        ],
        "description": header.description,
    }


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document."""
    points = document.list("controlPoints")
    if points and isinstance(points[-1], dict) and points[-1].get("intensity") not in (0, None):
        document.notes.warn("the last control point must have an intensity of 0", points[-1]["intensity"])
    events = events_of_points(document, POINT, "initialSharpness", SPAN, most=1.0)
    facts = {"carrier_hz": [SPAN.low, SPAN.high], "carrier_from": "sharpness"}
    return DecodedDocument(events, document.text("description"), facts)


FORMAT = HapticFormat(
    name="android_basic",
    title=TITLE,
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    bands=BANDS,
    recognise=has_points("sharpness"),
    instead="android (faster changes) or android_envelope (any frequency)",
)
