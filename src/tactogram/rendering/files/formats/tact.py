"""``.tact``, bHaptics Designer's patterns: the strength of a vest's motors every 20 ms.

The vendor publishes no schema. Members and their meaning are those that its own SDK reads (bhaptics/haptic-library,
whose samples also hold the frames that the Designer rendered from them) and those of the patterns that it and others
publish (haptic-guide, bhaptics-popone-support, bHapticsLib). A frame every 20 ms takes each motor's strength at its
time, in hundredths; fades are linear. The file names positions and motors, and no frequency.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, model_validator

from tactogram.errors import ParameterError
from tactogram.rendering.files.documents import (
    MOST_ENTRIES,
    DecodedDocument,
    DocumentHeader,
    DocumentPart,
    has_key,
    problems_of,
    sample_count,
)
from tactogram.rendering.files.envelope import HIGHEST_HZ, carrier, stepped_envelope, stepped_strength
from tactogram.rendering.files.format import HapticFormat
from tactogram.signal import Signal

FRAME_MS = 20
LEVELS = 100
POSITION = "VestFront"
"""Where a signal is written: all motors of the front of a vest, the most common device. A choice."""
COLUMNS, ROWS = (0, 0.333, 0.667, 1), (0, 0.25, 0.5, 0.75, 1)
"""Places of the 20 motors of either side of a vest, in the order of their numbers."""
MOTOR_HZ = 170.0
"""Assumed when a file is read, as for phones. A choice."""
_GRID_HZ = 1000.0
"""Steps per second in which effects are combined."""

Number = Annotated[float, BeforeValidator(lambda value: float(value) if isinstance(value, str) else value)]
"""Early files quote their numbers."""
Share = Annotated[Number, Field(ge=0, le=1)]
Milliseconds = Annotated[float, Field(ge=0)]
Playback = Literal["NONE", "FADE_IN", "FADE_OUT", "FADE_IN_OUT"]
_FADES = {"FADE_IN": [0, 1], "FADE_OUT": [1, 0], "FADE_IN_OUT": [0, 1, 0]}
"""Shares of the strength at equal times."""
_FADE_POINTS = 101


class Dot(DocumentPart):
    """Strength of a motor."""

    index: int = Field(ge=0)
    intensity: Share


class DotFeedback(DocumentPart):
    """Motors that are on for a time of the effect."""

    start: Milliseconds = Field(alias="startTime")
    end: Milliseconds = Field(alias="endTime")
    playback: Playback = Field("NONE", alias="playbackType")
    points: tuple[Dot, ...] = Field(alias="pointList", max_length=MOST_ENTRIES, strict=False)

    @model_validator(mode="after")
    def _order(self) -> DotFeedback:
        if self.end < self.start:
            raise ValueError(f"endTime must be at least startTime, got {self.end:g} and {self.start:g}")
        return self


class DotMode(DocumentPart):
    """Strengths by motor."""

    feedback: tuple[DotFeedback, ...] = Field(max_length=MOST_ENTRIES, strict=False)


class PathPoint(DocumentPart):
    """Strength at a place and a time of the effect."""

    x: Number
    y: Number
    intensity: Share
    time: Milliseconds


class PathFeedback(DocumentPart):
    """A place that moves; the player distributes it among motors."""

    playback: Playback = Field("NONE", alias="playbackType")
    moving: Literal["CONST_SPEED", "CONST_TDM"] = Field("CONST_TDM", alias="movingPattern")
    points: tuple[PathPoint, ...] = Field(alias="pointList", max_length=MOST_ENTRIES, strict=False)


class PathMode(DocumentPart):
    """Strengths by place."""

    feedback: tuple[PathFeedback, ...] = Field(max_length=MOST_ENTRIES, strict=False)


class Mode(DocumentPart):
    """Part of an effect at one position, in one of two modes."""

    mode: Literal["DOT_MODE", "PATH_MODE"]
    dots: DotMode = Field(alias="dotMode")
    paths: PathMode = Field(alias="pathMode")


class Effect(DocumentPart):
    """An effect: its start, its length, and its modes by position."""

    start: Milliseconds = Field(alias="startTime")
    length: Milliseconds = Field(alias="offsetTime")
    modes: dict[str, Mode]


class Track(DocumentPart):
    """Effects of a track."""

    enable: bool = True
    effects: tuple[Effect, ...] = Field(max_length=MOST_ENTRIES, strict=False)


class Motor(DocumentPart):
    """Place of a motor."""

    index: int = Field(ge=0)
    x: Number
    y: Number


class Layout(DocumentPart):
    """Device, and its motors by position."""

    type: str
    layouts: dict[str, Annotated[tuple[Motor, ...], Field(strict=False)]]


class Project(DocumentPart):
    """Tracks, and the layout of the device that they are for."""

    name: str
    description: str = ""
    layout: Layout
    tracks: tuple[Track, ...] = Field(max_length=MOST_ENTRIES, strict=False)

    @model_validator(mode="after")
    def _motors(self) -> Project:
        known = {name: {motor.index for motor in motors} for name, motors in self.layout.layouts.items()}
        for effect in (effect for track in self.tracks for effect in track.effects):
            for position, mode in effect.modes.items():
                if position not in known:
                    raise ValueError(f"position must be one of {', '.join(known)}, got {position!r}")
                used = {dot.index for feedback in mode.dots.feedback for dot in feedback.points}
                if strange := sorted(used - known[position]):
                    raise ValueError(f"{position} has no motor {strange[0]}")
        return self


class Pattern(DocumentPart):
    """A complete file."""

    project: Project


validate = partial(problems_of, Pattern)


def encode(signal: Signal, header: DocumentHeader) -> dict[str, Any]:
    """Return the document of a signal of one axis whose envelope is within 0 to 1.

    All motors of `POSITION` do the same. Steps change between frames, so that each frame falls into one of them.
    """
    edges, (strength,) = stepped_strength(
        signal, FRAME_MS, [(0.0, HIGHEST_HZ)], what="a bHaptics pattern", first_ms=FRAME_MS // 2
    )
    strength = np.rint(LEVELS * strength) / LEVELS
    first = np.flatnonzero(np.diff(strength, prepend=-1))
    ends = np.append(edges[first][1:], edges[-1])
    dots = [
        {
            "startTime": int(start),
            "endTime": int(end),
            "playbackType": "NONE",
            "pointList": _every_motor(float(share)) if share > 0 else [],
        }
        for start, end, share in zip(edges[first], ends, strength[first], strict=True)
    ]
    length = int(edges[-1])
    modes = {"VestBack": _mode([]), POSITION: _mode(dots)}
    project = {
        "createdAt": 0,
        "description": header.description,
        "layout": {"layouts": dict.fromkeys(modes, _LAYOUT), "name": "Tactot", "type": "Tactot"},
        "mediaFileDuration": length / 1e3,
        "name": "tactogram",
        "tracks": [
            {
                "effects": [{"modes": modes, "name": "Effect 1", "offsetTime": length, "startTime": 0}],
                "enable": True,
            }
        ],
        "updatedAt": 0,
    }
    return {"project": project, "durationMillis": length, "intervalMillis": FRAME_MS, "size": 20}


def decode(document: Any, rate: float | None = None) -> DecodedDocument:
    """Return the signal of a valid document: the strongest motor at any time, as a carrier of `MOTOR_HZ` at ``rate``.

    A path is as strong as its points and the lines between them.
    """
    project = Pattern.model_validate(document).project
    effects = [effect for track in project.tracks if track.enable for effect in track.effects]
    seconds = max((effect.start + effect.length for effect in effects), default=0.0) / 1e3
    count = sample_count(seconds, _GRID_HZ)
    if count < 1:
        raise ParameterError("the pattern holds no effect of 1 ms or more")
    strength = np.zeros(count)
    middles = 1e3 * (np.arange(count) + 0.5) / _GRID_HZ
    for effect in effects:
        for mode in effect.modes.values():
            for times, values in _dots(mode) if mode.mode == "DOT_MODE" else _paths(mode, effect.length):
                inside = slice(
                    *np.searchsorted(middles, effect.start + np.clip(times[[0, -1]], 0, effect.length))
                )
                own = np.interp(middles[inside] - effect.start, times, values)
                strength[inside] = np.maximum(strength[inside], own)
    envelope = stepped_envelope(np.arange(count + 1) / _GRID_HZ, strength, MOTOR_HZ)
    facts = {
        "carrier_hz": [MOTOR_HZ],
        "carrier_from": "nothing in the file: a choice",
        "left_out": "which motors",
    }
    return DecodedDocument(carrier(envelope, rate), project.description, facts)


_LAYOUT = [
    {"index": len(COLUMNS) * row + column, "x": x, "y": y}
    for row, y in enumerate(ROWS)
    for column, x in enumerate(COLUMNS)
]


def _every_motor(share: float) -> list[dict[str, Any]]:
    return [{"index": motor["index"], "intensity": share} for motor in _LAYOUT]


def _mode(dots: list[dict[str, Any]]) -> dict[str, Any]:
    path = {"movingPattern": "CONST_SPEED", "playbackType": "NONE", "visible": True, "pointList": []}
    return {
        "dotMode": {"dotConnected": False, "feedback": dots},
        "mode": "DOT_MODE",
        "pathMode": {"feedback": [path]},
    }


def _dots(mode: Mode) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Yield times (ms) and strength of each feedback's strongest motor."""
    for feedback in mode.dots.feedback:
        if feedback.points:
            strongest = max(dot.intensity for dot in feedback.points)
            yield _faded(np.array([feedback.start, feedback.end]), np.full(2, strongest), feedback.playback)


def _paths(mode: Mode, length: float) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Yield times (ms) and strength of each path; a single point stays until the end of the effect."""
    for feedback in mode.paths.feedback:
        points = sorted((point.time, point.intensity) for point in feedback.points)
        if len(points) == 1:
            points.append((max(length, points[0][0]), points[0][1]))
        if points:
            times, strength = np.array(points).T
            yield _faded(times, strength, feedback.playback)


def _faded(
    times: NDArray[np.float64], strength: NDArray[np.float64], playback: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a line with its fade."""
    if playback == "NONE":
        return times, strength
    fine = np.linspace(times[0], times[-1], _FADE_POINTS)
    fade = _FADES[playback]
    return fine, np.interp(fine, times, strength) * np.interp(
        fine, np.linspace(times[0], times[-1], len(fade)), fade
    )


FORMAT = HapticFormat(
    name="tact",
    title="bHaptics pattern",
    suffix=".tact",
    holds="envelope",
    encode=encode,
    decode=decode,
    validate=validate,
    recognise=has_key("project"),
)
