"""Events of an effect's tracks, and the way back: tracks from events and signals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
from tactogram.rendering.drive.axes import to_one_axis
from tactogram.rendering.drive.level_scaling import without_constant
from tactogram.rendering.effects.effect import (
    DIGITS,
    LEAST_S,
    LONGEST_S,
    LOWEST_HZ,
    Effect,
    Point,
    Track,
    Transient,
)
from tactogram.rendering.effects.effect import MOST_POINTS as MOST_TRANSIENTS
from tactogram.rendering.files.analysis import HIGHEST_HZ, carrier, events_of
from tactogram.rendering.files.conversion import GRAVITY
from tactogram.rendering.files.events import JUMP_S, Events, Part, densified, joined, thinned
from tactogram.rendering.files.events import Transient as Tap
from tactogram.signal import Signal

AMPLITUDE_STEP, FREQUENCY_STEP_HZ = 0.02, 5.0
"""Largest deviation of a track's lines from the envelope that it is made of."""
MOST_POINTS = 300
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
    if len(events.transients) > MOST_TRANSIENTS:
        raise ParameterError(
            f"a track has at most {MOST_TRANSIENTS} transients, got {len(events.transients)}; cut the file"
        )
    whole = events.joined.within(0.0, events.seconds)
    amplitude = _points(whole.times, np.clip(whole.amplitude, 0, 1), AMPLITUDE_STEP)
    # The frequency of silence, which files state, too, is no frequency.
    at = densified(whole.times)
    heard = whole.at(at) > 0
    at = at[heard] if heard.any() else whole.times[:1]
    hz = whole.hz(at)
    frequency = _points(at, np.clip(hz, LOWEST_HZ, HIGHEST_HZ), FREQUENCY_STEP_HZ)
    if np.ptp(hz) < FREQUENCY_STEP_HZ:
        frequency = frequency[:1]
    transients = tuple(
        Transient(
            time=round(one.time, DIGITS),
            amplitude=float(np.clip(one.amplitude - whole.at(one.time), 0, 1)),
            frequency=float(np.clip(one.frequency, LOWEST_HZ, HIGHEST_HZ)),
        )
        for one in events.transients
    )
    silent = all(point.value == 0 for point in amplitude)
    return Track(title=title[:60]).changed(
        amplitude=() if silent else amplitude, frequency=frequency, transients=transients
    )


def track_of_signal(signal: Signal, title: str) -> Track:
    """Return a track close to a signal: its envelope relative to the peak, its frequency and its transients.

    Several axes become one, and a constant is removed, as when a file is written. Raises `ParameterError` if the signal
    is over displacement or too long.
    """
    signal, _ = without_constant(signal, least=GRAVITY)
    one, _ = to_one_axis(signal)
    events = events_of(one)
    fits = events.peak == 0 or (signal.unit == "1" and events.peak <= 1)
    return track_of(events if fits else events.scaled(1 / events.peak), title)


def _part(track: Track) -> Part:
    (times, amplitude), (at, hz) = (
        np.array([(point.time, point.value) for point in line]).T
        for line in (track.amplitude, track.frequency)
    )
    return Part.of(times, track.gain * amplitude, at, hz)


def _transients(tracks: list[Track], whole: Part) -> list[Tap]:
    """Return the transients; at the same time, amplitudes add up, and the frequency is their weighted mean."""
    by_time: dict[float, Tap] = {}
    for track in tracks:
        for one in track.transients:
            added = track.gain * one.amplitude
            before = by_time.get(one.time, Tap(one.time, 0.0, 0.0))
            amplitude = before.amplitude + added
            if amplitude > 0:
                hz = (before.amplitude * before.frequency + added * one.frequency) / amplitude
                by_time[one.time] = Tap(one.time, amplitude, hz)
    return [replace(tap, amplitude=tap.amplitude + float(whole.at(tap.time))) for tap in by_time.values()]


def _points(times: NDArray[np.float64], values: NDArray[np.float64], tolerance: float) -> tuple[Point, ...]:
    """Return few points of a line; jumps take `LEAST_S`."""
    chosen = np.arange(len(times))
    while True:
        # Once more, since long lines are thinned in pieces.
        for _ in range(2):
            chosen = chosen[thinned(times[chosen], values[chosen], tolerance)]
        if len(chosen) <= MOST_POINTS:
            break
        tolerance *= 2
    at = [round(float(times[i]), DIGITS) for i in chosen]
    for i in range(1, len(at)):
        if at[i] - at[i - 1] < 2 * JUMP_S:
            at[i - 1] = round(at[i - 1], 4)
        at[i] = round(max(at[i], at[i - 1] + LEAST_S), DIGITS)
    rounded = [round(float(values[i]), DIGITS) for i in chosen]
    return tuple(
        Point(time=time, value=value) for time, value in zip(at, rounded, strict=True) if time <= LONGEST_S
    )
