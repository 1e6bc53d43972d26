"""Reader of AHAP: a pattern's events and curves become an envelope."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import DecodedDocument
from tactogram.rendering.files.envelope import PULSE_S, Envelope, Pulse, carrier
from tactogram.rendering.files.formats.ahap.rules import CONTROL, SPAN, Event, Pattern

GRID_S = 0.0005
"""Grid on which events and curves are combined, s."""


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the signal of a valid document, as a carrier of `SPAN`'s frequencies at ``rate``."""
    pattern = Pattern.model_validate(document)
    events = [entry.event for entry in pattern.entries if entry.event is not None]
    haptic = [event for event in events if event.kind.startswith("Haptic")]
    if not haptic:
        raise ParameterError("the pattern holds no haptic event")
    ends = [
        event.time + event.duration for event in haptic if event.duration and event.kind == "HapticContinuous"
    ]
    seconds = max(ends, default=0.0)
    # A transient that begins within a continuous vibration ends with it.
    late = [event.time + PULSE_S for event in haptic if event.time >= seconds]
    seconds = max([seconds, *late])
    intensity = _control(pattern, "HapticIntensityControl", 1.0)
    sharpness = _control(pattern, "HapticSharpnessControl", 0.0)
    amplitude, frequency = _track(haptic, seconds, intensity, sharpness)
    pulses = tuple(
        Pulse(
            event.time,
            (event.value("HapticIntensity", 1.0) * float(intensity(event.time))) ** 2,
            float(SPAN.hz(np.clip(event.value("HapticSharpness", 0.5) + sharpness(event.time), 0, 1))),
        )
        for event in haptic
        if event.kind == "HapticTransient"
    )
    times = np.arange(len(amplitude), dtype=np.float64) * GRID_S
    envelope = Envelope(seconds, times, amplitude, times, frequency, pulses)
    facts: dict[str, Any] = {"carrier_hz": [SPAN.low, SPAN.high], "carrier_from": "sharpness"}
    controls = {
        part.name for entry in pattern.entries if (part := entry.curve or entry.parameter) is not None
    }
    left_out = [f"{len(events) - len(haptic)} audio events"] if len(haptic) < len(events) else []
    left_out += sorted(controls - CONTROL.keys())
    if left_out:
        facts["left_out"] = ", ".join(left_out)
    return DecodedDocument(carrier(envelope, rate), pattern.metadata.description, facts, envelope)


class _Line:
    """Control over time: linear within a curve, constant after it."""

    def __init__(self, pieces: list[tuple[list[float], list[float]]], before: float) -> None:
        times, values = [0.0], [before]
        for at, value in sorted(pieces):
            while times and times[-1] > at[0]:
                times.pop()
                values.pop()
            if not times or times[-1] < at[0]:
                times.append(at[0])
                values.append(values[-1] if values else before)
            times += at
            values += value
        self._times, self._values = np.array(times), np.array(values)

    def __call__(self, t: NDArray[np.float64] | float) -> NDArray[np.float64]:
        return np.asarray(np.interp(t, self._times, self._values))


def _control(pattern: Pattern, name: str, before: float) -> _Line:
    pieces = []
    for entry in pattern.entries:
        if (curve := entry.curve) is not None and curve.name == name:
            pieces.append(([curve.time + p.time for p in curve.points], [p.value for p in curve.points]))
        if (step := entry.parameter) is not None and step.name == name:
            pieces.append(([step.time], [step.value]))
    return _Line(pieces, before)


def _track(
    events: list[Event], seconds: float, intensity: _Line, sharpness: _Line
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return amplitude and frequency of all continuous events on a grid of `GRID_S`."""
    t = np.arange(int(np.ceil(seconds / GRID_S)) + 1, dtype=np.float64) * GRID_S
    strength, own = np.zeros(len(t)), np.full(len(t), 0.5)
    for event in sorted(events, key=lambda event: event.time):
        if event.kind == "HapticContinuous" and event.duration is not None:
            inside = slice(
                int(np.ceil(event.time / GRID_S)),
                int(np.ceil((event.time + event.duration) / GRID_S - 1e-6)) + 1,
            )
            strength[inside] = event.value("HapticIntensity", 1.0)
            own[inside] = event.value("HapticSharpness", 0.5)
    amplitude = np.clip(strength * intensity(t), 0, 1) ** 2
    return amplitude, SPAN.hz(np.clip(own + sharpness(t), 0, 1))
