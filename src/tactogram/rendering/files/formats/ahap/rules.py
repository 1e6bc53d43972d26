"""Rules of AHAP patterns, and what of them is read.

Core Haptics accepts invalid files silently: it ignores unknown keys, clips values and replaces missing ones by
defaults, so everything is checked here. The limits of 16 points per curve and 30 s per event are those of Meta's
exporter (haptic_data, MIT).
"""

from __future__ import annotations

from functools import partial
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tactogram.rendering.files.documents import MOST_ENTRIES, DocumentPart, problems_of
from tactogram.rendering.files.envelope import FrequencySpan

SPAN = FrequencySpan(65.0, 300.0)
"""Sharpness 0 and 1, Hz: AhapEncoder of the MPEG haptics reference software. Apple names no frequency."""
MOST_POINTS = 16
LONGEST_EVENT_S = 30.0

Seconds = Annotated[float, Field(ge=0)]
HAPTIC = {"HapticIntensity": (0.0, 1.0), "HapticSharpness": (0.0, 1.0)}
CONTROL = {"HapticIntensityControl": (0.0, 1.0), "HapticSharpnessControl": (-1.0, 1.0)}
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

    ranges: ClassVar = HAPTIC

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
        if self.name not in (*CONTROL, *_OTHER_CONTROLS):
            raise ValueError(f"ParameterID of a curve must be one of {', '.join(CONTROL)}, got {self.name!r}")
        times = [point.time for point in self.points]
        if sorted(times) != times:
            raise ValueError("control points must be in order of time")
        for point in self.points:
            _check_range(self.name, point.value, CONTROL)
        return self


class Dynamic(EventParameter):
    """Parameter of all events from a time on."""

    ranges: ClassVar = CONTROL

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


def _check_range(name: str, value: float, known: dict[str, tuple[float, float]]) -> None:
    low, high = known.get(name, (-np.inf, np.inf))
    if not low <= value <= high:
        raise ValueError(f"{name} must be {low:g} to {high:g}, got {value:g}")
