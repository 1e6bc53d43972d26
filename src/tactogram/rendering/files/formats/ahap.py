"""AHAP, Apple's haptic patterns (Core Haptics): an envelope, its sharpness, and transients.

"Representing haptic patterns in AHAP files", Apple developer documentation. Core Haptics accepts invalid files
silently: it ignores unknown keys, clips values and replaces missing ones by defaults, so everything is checked here.
The limits of 16 points per curve and 30 s per event are those of Meta's exporter (haptic_data, MIT). As there,
intensity is the square root of the amplitude. A curve acts on all events at once: intensity is multiplied, sharpness
added (Apple; the MPEG reference software does the same).
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import (
    MOST_ENTRIES,
    DecodedDocument,
    DocumentHeader,
    DocumentPart,
    has_key,
    problems_of,
)
from tactogram.rendering.files.envelope import (
    PULSE_S,
    Envelope,
    FrequencySpan,
    Pulse,
    carrier,
    envelope_of,
    thinned,
)
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

SPAN = FrequencySpan(65.0, 300.0)
"""Sharpness 0 and 1, Hz: AhapEncoder of the MPEG haptics reference software. Apple names no frequency."""
MOST_POINTS = 16
LONGEST_EVENT_S = 30.0
INTENSITY_STEP, SHARPNESS_STEP = 0.01, 0.02
"""Largest deviation of a curve from the envelope."""
SHORTEST_S = 1e-5
_DIGITS = 6

Seconds = Annotated[float, Field(ge=0)]
_HAPTIC = {"HapticIntensity": (0.0, 1.0), "HapticSharpness": (0.0, 1.0)}
_CONTROL = {"HapticIntensityControl": (0.0, 1.0), "HapticSharpnessControl": (-1.0, 1.0)}
_OTHER_CONTROLS = (
    "HapticAttackTimeControl",
    "HapticDecayTimeControl",
    "HapticReleaseTimeControl",
    "AudioVolumeControl",
    "AudioPanControl",
    "AudioBrightnessControl",
    "AudioPitchControl",
    "AudioAttackTimeControl",
    "AudioDecayTimeControl",
    "AudioReleaseTimeControl",
)
"""Known to Core Haptics (CHHapticDynamicParameter.ID); ignored here."""


class EventParameter(DocumentPart):
    """Constant of an event."""

    ranges: ClassVar = _HAPTIC

    name: str = Field(alias="ParameterID")
    value: float = Field(alias="ParameterValue")

    @model_validator(mode="after")
    def _within(self) -> Self:
        _check_range(self.name, self.value, self.ranges)
        return self


class Event(DocumentPart):
    """A transient or a continuous vibration; audio events are ignored."""

    time: Seconds = Field(alias="Time")
    kind: Literal["HapticTransient", "HapticContinuous", "AudioContinuous", "AudioCustom"] = Field(
        alias="EventType"
    )
    duration: float | None = Field(None, alias="EventDuration", gt=0)
    parameters: tuple[EventParameter, ...] = Field((), alias="EventParameters", strict=False)

    @model_validator(mode="after")
    def _length(self) -> Event:
        if self.kind == "HapticContinuous":
            if self.duration is None:
                raise ValueError("a HapticContinuous event needs an EventDuration")
            if self.duration > LONGEST_EVENT_S:
                raise ValueError(
                    f"EventDuration must be at most {LONGEST_EVENT_S:g} s, got {self.duration:g}; split it"
                )
        return self

    def value(self, name: str, default: float) -> float:
        """Return a parameter's value."""
        return next((p.value for p in self.parameters if p.name == name), default)


class Point(DocumentPart):
    """Control point, its time relative to the curve's."""

    time: Seconds = Field(alias="Time")
    value: float = Field(alias="ParameterValue")


class Curve(DocumentPart):
    """Parameter of all events over time, linear between its points."""

    name: str = Field(alias="ParameterID")
    time: Seconds = Field(alias="Time")
    points: tuple[Point, ...] = Field(
        alias="ParameterCurveControlPoints", min_length=1, max_length=MOST_POINTS, strict=False
    )

    @model_validator(mode="after")
    def _points(self) -> Curve:
        if self.name not in (*_CONTROL, *_OTHER_CONTROLS):
            raise ValueError(
                f"ParameterID of a curve must be one of {', '.join(_CONTROL)}, got {self.name!r}"
            )
        times = [point.time for point in self.points]
        if sorted(times) != times:
            raise ValueError("control points must be in order of time")
        for point in self.points:
            _check_range(self.name, point.value, _CONTROL)
        return self


class Dynamic(EventParameter):
    """Parameter of all events from a time on."""

    ranges: ClassVar = _CONTROL

    time: Seconds = Field(alias="Time")


class Entry(DocumentPart):
    """Entry of the pattern."""

    event: Event | None = Field(None, alias="Event")
    curve: Curve | None = Field(None, alias="ParameterCurve")
    parameter: Dynamic | None = Field(None, alias="Parameter")

    @model_validator(mode="after")
    def _one(self) -> Entry:
        if sum(part is not None for part in (self.event, self.curve, self.parameter)) != 1:
            raise ValueError("an entry must hold one of Event, ParameterCurve and Parameter")
        return self


class Metadata(DocumentPart):
    """Origin of a pattern; Core Haptics ignores it."""

    description: str = Field("", alias="Description")


class Pattern(DocumentPart):
    """A complete file."""

    version: float = Field(1.0, alias="Version")
    metadata: Metadata = Field(Metadata(Description=""), alias="Metadata")
    entries: tuple[Entry, ...] = Field(alias="Pattern", min_length=1, max_length=MOST_ENTRIES, strict=False)


validate = partial(problems_of, Pattern)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1."""
    if signal.seconds < SHORTEST_S:
        raise ParameterError(f"AHAP needs at least {SHORTEST_S:g} s, got {signal.seconds:g} s")
    envelope = envelope_of(signal)
    intensity = np.sqrt(np.minimum(envelope.amplitude, 1))
    sharpness = SPAN.share(envelope.frequency)
    entries = [
        _continuous(start, min(LONGEST_EVENT_S, envelope.seconds - start)) for start in _starts(envelope)
    ]
    for pulse in envelope.pulses:
        control = float(np.interp(pulse.time, envelope.times, intensity))
        own = float(SPAN.share(pulse.frequency)) - float(np.interp(pulse.time, envelope.times, sharpness))
        strength = np.sqrt(pulse.amplitude) / control if control > 0 else 1.0
        entries.append(_event(pulse.time, "HapticTransient", min(1.0, strength), max(0.0, own)))
    entries += _curves("HapticIntensityControl", envelope.times, intensity, INTENSITY_STEP)
    entries += _curves("HapticSharpnessControl", envelope.times, sharpness, SHARPNESS_STEP)
    return {
        "Version": 1.0,
        "Metadata": {"Project": "tactogram", "Description": header.description},
        "Pattern": sorted(entries, key=lambda entry: float(next(iter(entry.values()))["Time"])),
    }


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
    times = np.arange(len(amplitude), dtype=np.float64) * _GRID_S
    envelope = Envelope(seconds, times, amplitude, times, frequency, pulses)
    facts: dict[str, Any] = {"carrier_hz": [SPAN.low, SPAN.high], "carrier_from": "sharpness"}
    controls = {
        part.name for entry in pattern.entries if (part := entry.curve or entry.parameter) is not None
    }
    left_out = [f"{len(events) - len(haptic)} audio events"] if len(haptic) < len(events) else []
    left_out += sorted(controls - _CONTROL.keys())
    if left_out:
        facts["left_out"] = ", ".join(left_out)
    return DecodedDocument(carrier(envelope, rate), pattern.metadata.description, facts)


_GRID_S = 0.0005
"""Grid on which events and curves are combined, s."""


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
    """Return amplitude and frequency of all continuous events on a grid of `_GRID_S`."""
    t = np.arange(int(np.ceil(seconds / _GRID_S)) + 1, dtype=np.float64) * _GRID_S
    strength, own = np.zeros(len(t)), np.full(len(t), 0.5)
    for event in sorted(events, key=lambda event: event.time):
        if event.kind == "HapticContinuous" and event.duration is not None:
            inside = slice(
                int(np.ceil(event.time / _GRID_S)),
                int(np.ceil((event.time + event.duration) / _GRID_S - 1e-6)) + 1,
            )
            strength[inside] = event.value("HapticIntensity", 1.0)
            own[inside] = event.value("HapticSharpness", 0.5)
    amplitude = np.clip(strength * intensity(t), 0, 1) ** 2
    return amplitude, SPAN.hz(np.clip(own + sharpness(t), 0, 1))


def _starts(envelope: Envelope) -> NDArray[np.float64]:
    starts = np.arange(0, envelope.seconds, LONGEST_EVENT_S)
    return starts[envelope.seconds - starts >= SHORTEST_S]


def _continuous(start: float, seconds: float) -> dict[str, Any]:
    entry = _event(start, "HapticContinuous", 1.0, 0.0)
    entry["Event"]["EventDuration"] = round(seconds, _DIGITS)
    return entry


def _event(time: float, kind: str, intensity: float, sharpness: float) -> dict[str, Any]:
    parameters = [("HapticIntensity", intensity), ("HapticSharpness", sharpness)]
    return {
        "Event": {
            "Time": round(time, _DIGITS),
            "EventType": kind,
            "EventParameters": [
                {"ParameterID": name, "ParameterValue": round(float(value), 4)} for name, value in parameters
            ],
        }
    }


def _curves(
    name: str, times: NDArray[np.float64], values: NDArray[np.float64], tolerance: float
) -> list[dict[str, Any]]:
    """Return curves of at most `MOST_POINTS`; each begins where the previous one ended."""
    chosen = thinned(times, values, tolerance)
    curves = []
    for first in range(0, max(1, len(chosen) - 1), MOST_POINTS - 1):
        indices = chosen[first : first + MOST_POINTS]
        start = round(float(times[indices[0]]), _DIGITS)
        points = [
            {
                "Time": round(max(0.0, float(times[i]) - start), _DIGITS),
                "ParameterValue": round(float(values[i]), 4),
            }
            for i in indices
        ]
        curve = {"ParameterID": name, "Time": start, "ParameterCurveControlPoints": points}
        curves.append({"ParameterCurve": curve})
    return curves


def _check_range(name: str, value: float, known: dict[str, tuple[float, float]]) -> None:
    low, high = known.get(name, (-np.inf, np.inf))
    if not low <= value <= high:
        raise ValueError(f"{name} must be {low:g} to {high:g}, got {value:g}")


FORMAT = HapticFormat(
    name="ahap",
    title="AHAP (Apple)",
    suffix=".ahap",
    holds="envelope",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_key("Pattern"),
)
