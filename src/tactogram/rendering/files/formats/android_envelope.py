"""Android 16's envelope with frequency: the calls of `VibrationEffect.WaveformEnvelopeBuilder` as JSON.

``initialFrequencyHz`` is of ``setInitialFrequencyHz``, each entry of ``controlPoints`` of a call of
``addControlPoint(amplitude, frequencyHz, durationMillis)``. An amplitude of 1 is the strongest that the phone can do.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactogram.rendering.files.control_points import BANDS, control_points, events_of_points, has_points
from tactogram.rendering.files.documents import DecodedDocument, DocumentHeader, Node
from tactogram.rendering.files.events import Events
from tactogram.rendering.files.format import HapticFormat

TITLE = "Android waveform envelope (API 36)"
POINT = ("amplitude", "frequencyHz", "durationMillis")
"""Arguments of a call of addControlPoint."""


def encode(events: Events, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of events within 0 to 1."""
    points = control_points(events, what=TITLE)
    return {
        "format": "android-waveform-envelope",
        "initialFrequencyHz": round(points.start_hz, 1),
        "controlPoints": [
            dict(zip(POINT, (round(float(amplitude), 4), round(float(hz), 1), int(ms)), strict=True))
            for amplitude, hz, ms in zip(points.amplitude, points.hz, points.ms, strict=True)
        ],
        "description": header.description,
    }


def decode(document: Node) -> DecodedDocument:
    """Return the events of a document."""
    events = events_of_points(document, POINT, "initialFrequencyHz", None, most=np.inf)
    tones = [part.frequency for part in events.parts] + [
        np.array([tap.frequency]) for tap in events.transients
    ]
    hz = np.concatenate(tones) if tones else np.array([0.0])
    facts = {"carrier_hz": [float(hz.min()), float(hz.max())], "carrier_from": "frequencyHz"}
    return DecodedDocument(events, document.text("description"), facts)


FORMAT = HapticFormat(
    name="android_envelope",
    title=TITLE,
    suffix=".json",
    holds="envelope",
    encode=encode,
    decode=decode,
    bands=BANDS,
    recognise=has_points("frequencyHz"),
    instead="android (a strength every 10 ms, at the phone's own frequency)",
)
