"""Effect: tracks of a drawn amplitude, a drawn frequency and transients, as values."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tactogram.errors import DataError, ParameterError
from tactogram.rendering.files.analysis import HIGHEST_HZ
from tactogram.rendering.files.events import PHONE_HZ, PULSE_S
from tactogram.validation import validated

LONGEST_S = 60.0
LEAST_S = 0.001
"""Least distance between two points of a line, s: a jump takes this long."""
LOWEST_HZ = 20.0
MOST_POINTS, MOST_TRACKS = 2000, 32
STRONGEST_GAIN = 2.0
DIGITS = 6
"""Decimals of times and values, as in files."""

Seconds = Annotated[float, Field(ge=0, le=LONGEST_S)]
Share = Annotated[float, Field(ge=0, le=1)]
Hertz = Annotated[float, Field(ge=LOWEST_HZ, le=HIGHEST_HZ)]


class EffectPart(BaseModel):
    """Part of an effect: frozen, strictly typed, finite numbers; unknown keys are ignored."""

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore", allow_inf_nan=False)


class Point(EffectPart):
    """Point of a line: ``time`` in s, ``value`` an amplitude (0 to 1) or a frequency (Hz)."""

    time: Seconds
    value: float


Points = Annotated[tuple[Point, ...], Field(max_length=MOST_POINTS, strict=False)]


class Transient(EffectPart):
    """A moment too short for a line, as `events.Transient`, but that its ``amplitude`` is added to the track's."""

    time: Seconds
    amplitude: Share
    frequency: Hertz


class Track(EffectPart):
    """A vibration: amplitude and frequency over time, linear between their points, and transients.

    The amplitude is 0 before its first and after its last point, the frequency constant there. All times are those of
    the effect. Times of a line differ by `LEAST_S` or more; transients are in order.
    """

    title: Annotated[str, Field(min_length=1, max_length=60)] = "Track"
    amplitude: Points = ()
    frequency: Annotated[Points, Field(min_length=1)] = (Point(time=0.0, value=PHONE_HZ),)
    transients: Annotated[tuple[Transient, ...], Field(max_length=MOST_POINTS, strict=False)] = ()
    gain: Annotated[float, Field(ge=0, le=STRONGEST_GAIN)] = 1.0
    muted: bool = False

    @model_validator(mode="after")
    def _lines(self) -> Self:
        for name, points, low, high in (
            ("amplitude", self.amplitude, 0.0, 1.0),
            ("frequency", self.frequency, LOWEST_HZ, HIGHEST_HZ),
        ):
            if any(b.time - a.time < LEAST_S - 1e-9 for a, b in pairwise(points)):
                raise ValueError(f"times of the {name} must be in order, {LEAST_S:g} s or more apart")
            for point in points:
                if not low <= point.value <= high:
                    raise ValueError(f"{name} must be {low:g} to {high:g}, got {point.value:g}")
        if any(b.time < a.time for a, b in pairwise(self.transients)):
            raise ValueError("transients must be in order of time")
        return self

    @property
    def start(self) -> float:
        """Time of the first point of the amplitude or the first transient, s; 0 of an empty track."""
        starts = [point.time for point in self.amplitude[:1]]
        return min([*starts, *(one.time for one in self.transients[:1])], default=0.0)

    @property
    def end(self) -> float:
        """Time at which amplitude and transients have ended, s."""
        ends = [point.time for point in self.amplitude[-1:]]
        ends += [transient.time + PULSE_S for transient in self.transients[-1:]]
        return round(max(ends, default=0.0), DIGITS)

    def changed(self, **values: Any) -> Track:
        """Return a track with other values; `ParameterError` if they are not valid."""
        return validated(Track, {**dict(self), **values}, where="")


class Effect(EffectPart):
    """Tracks that play together. ``simulated`` if any of them derives from a simulated signal."""

    title: Annotated[str, Field(min_length=1, max_length=120)] = "Effect"
    tracks: Annotated[tuple[Track, ...], Field(max_length=MOST_TRACKS, strict=False)] = ()
    simulated: bool = False

    @property
    def seconds(self) -> float:
        """End of the last track, s, muted ones included."""
        return max((track.end for track in self.tracks), default=0.0)

    def changed(self, **values: Any) -> Effect:
        """Return an effect with other values; `ParameterError` if they are not valid."""
        return validated(Effect, {**dict(self), **values}, where="")

    def track(self, number: int) -> Track:
        """Return a track by its index; `ParameterError` if there is none."""
        if not 0 <= number < len(self.tracks):
            raise ParameterError(f"the effect has {len(self.tracks)} tracks, there is no {number + 1}.")
        return self.tracks[number]

    def with_track(self, number: int, track: Track) -> Effect:
        """Return an effect with another track in place of one."""
        self.track(number)
        return self.changed(tracks=(*self.tracks[:number], track, *self.tracks[number + 1 :]))

    def to_json(self) -> str:
        """Return the effect as a line of JSON."""
        return self.model_dump_json()


def effect_from_json(text: str, *, where: str) -> Effect:
    """Return the effect in a JSON text; `DataError` if it is damaged. ``where`` names it in the error."""
    try:
        return Effect.model_validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(map(str, first["loc"])) or "document"
        raise DataError(f"{where}: not an effect: {place}: {first['msg']}") from None
