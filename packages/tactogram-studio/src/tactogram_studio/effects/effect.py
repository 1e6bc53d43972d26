"""Effect: tracks of a drawn amplitude, a drawn frequency and transients, as values; their mix, and the way back."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from tactogram.errors import DataError, ParameterError
from tactogram.rendering import (
    GRAVITY,
    HIGHEST_HZ,
    JUMP_S,
    PHONE_HZ,
    PULSE_S,
    Events,
    Part,
    Transient as Tap,
    carrier,
    densified,
    events_of,
    joined,
    thinned,
    to_one_axis,
    without_constant,
)
from tactogram.signal import Signal
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
        return min([*starts, *(transient.time for transient in self.transients[:1])], default=0.0)

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
        field = ".".join(map(str, first["loc"])) or "document"
        raise DataError(where, f"not an effect: {field}: {first['msg']}") from None


AMPLITUDE_STEP, FREQUENCY_STEP_HZ = 0.02, 5.0
"""Largest deviation of a track's lines from the envelope that it is made of."""
MADE_POINTS = 300
"""Points of a line made of an envelope: with more, the deviation is doubled until they fit."""


def mixed(effect: Effect) -> Events:
    """Return the events of all tracks that are not muted, a vibration for each, from 0 s to the end of the last one.

    Transients at the same time become one of their sum. Raises `ParameterError` if nothing sounds.
    """
    tracks = [track for track in effect.tracks if not track.muted and track.gain > 0]
    seconds = max((track.end for track in tracks), default=0.0)
    if seconds == 0:
        raise ParameterError("nothing to play: add a ready effect, or draw on a track that is not muted")
    parts = [_part(track) for track in tracks if track.amplitude]
    events = Events.of(parts, _transients(tracks, joined(parts)), seconds, limited=False)
    if events.peak == 0:
        raise ParameterError("nothing to play: every amplitude is 0; raise one")
    return events


def signal_of(effect: Effect) -> Signal:
    """Return the vibration of an effect, of unit 1; `ParameterError` if nothing sounds."""
    return carrier(mixed(effect))


def track_of(events: Events, title: str) -> Track:
    """Return a track close to events within 0 to 1; `ParameterError` if they are longer than an effect can be."""
    if events.seconds > LONGEST_S:
        raise ParameterError(f"an effect lasts at most {LONGEST_S:g} s, got {events.seconds:g} s; cut it")
    if len(events.transients) > MOST_POINTS:
        raise ParameterError(
            f"a track has at most {MOST_POINTS} transients, got {len(events.transients)}; cut the file"
        )
    whole = events.joined.within(0.0, events.seconds)
    amplitude = _points(whole.times, np.clip(whole.amplitude, 0, 1), AMPLITUDE_STEP)
    # The frequency of silence, which files state, too, is no frequency.
    times = densified(whole.times)
    heard = whole.at(times) > 0
    times = times[heard] if heard.any() else whole.times[:1]
    hz = whole.hz(times)
    frequency = _points(times, np.clip(hz, LOWEST_HZ, HIGHEST_HZ), FREQUENCY_STEP_HZ)
    if np.ptp(hz) < FREQUENCY_STEP_HZ:
        frequency = frequency[:1]
    transients = tuple(
        Transient(
            time=round(transient.time, DIGITS),
            amplitude=float(np.clip(transient.amplitude - whole.at(transient.time), 0, 1)),
            frequency=float(np.clip(transient.frequency, LOWEST_HZ, HIGHEST_HZ)),
        )
        for transient in events.transients
    )
    silent = all(point.value == 0 for point in amplitude)
    lines = {} if silent else {"amplitude": amplitude, "frequency": frequency}
    return Track(title=title[:60]).changed(transients=transients, **lines)


def track_of_signal(signal: Signal, title: str) -> Track:
    """Return a track close to a signal: its envelope relative to the peak, its frequency and its transients.

    Several axes become one, and a constant is removed, as when a file is written. Raises `ParameterError` if the signal
    is over displacement or too long.
    """
    signal, _ = without_constant(signal, least=GRAVITY)
    vibration, _ = to_one_axis(signal)
    events = events_of(vibration)
    fits = events.peak == 0 or (signal.unit == "1" and events.peak <= 1)
    return track_of(events if fits else events.scaled(1 / events.peak), title)


def _part(track: Track) -> Part:
    (times, amplitude), (hz_times, hz) = (
        np.array([(point.time, point.value) for point in line]).T
        for line in (track.amplitude, track.frequency)
    )
    return Part.of(times, track.gain * amplitude, hz_times, hz)


def _transients(tracks: list[Track], whole: Part) -> list[Tap]:
    """Return the transients; at the same time, amplitudes add up, and the frequency is their weighted mean."""
    by_time: dict[float, Tap] = {}
    for track in tracks:
        for transient in track.transients:
            added = track.gain * transient.amplitude
            before = by_time.get(transient.time, Tap(transient.time, 0.0, 0.0))
            amplitude = before.amplitude + added
            if amplitude > 0:
                hz = (before.amplitude * before.frequency + added * transient.frequency) / amplitude
                by_time[transient.time] = Tap(transient.time, amplitude, hz)
    return [replace(tap, amplitude=tap.amplitude + float(whole.at(tap.time))) for tap in by_time.values()]


def _points(times: NDArray[np.float64], values: NDArray[np.float64], tolerance: float) -> tuple[Point, ...]:
    """Return few points of a line; jumps take `LEAST_S`."""
    chosen = np.arange(len(times))
    while True:
        # Once more, since long lines are thinned in pieces.
        for _ in range(2):
            chosen = chosen[thinned(times[chosen], values[chosen], tolerance)]
        if len(chosen) <= MADE_POINTS:
            break
        tolerance *= 2
    rounded_times = [round(float(times[i]), DIGITS) for i in chosen]
    for i in range(1, len(rounded_times)):
        if rounded_times[i] - rounded_times[i - 1] < 2 * JUMP_S:
            rounded_times[i - 1] = round(rounded_times[i - 1], 4)
        rounded_times[i] = round(max(rounded_times[i], rounded_times[i - 1] + LEAST_S), DIGITS)
    rounded = [round(float(values[i]), DIGITS) for i in chosen]
    return tuple(
        Point(time=time, value=value)
        for time, value in zip(rounded_times, rounded, strict=True)
        if time <= LONGEST_S
    )
