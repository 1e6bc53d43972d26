"""Mix of an effect's tracks to one envelope, and the way back: tracks from envelopes and signals."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tactogram.errors import ParameterError
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
from tactogram.rendering.files.conversion import GRAVITY
from tactogram.rendering.files.envelope import (
    HIGHEST_HZ,
    STEP_S,
    Envelope,
    Pulse,
    carrier,
    densified,
    envelope_of,
    thinned,
)
from tactogram.rendering.files.reduction import to_one_axis
from tactogram.signal import Signal

AMPLITUDE_STEP, FREQUENCY_STEP_HZ = 0.02, 5.0
"""Largest deviation of a track's lines from the envelope that it is made of."""
MOST_POINTS = 300
"""Points of a line made of an envelope: with more, the deviation is doubled until they fit."""
_OUTSIDE = 1e-9
"""Weight of a silent track's frequency: it counts where nothing else sounds."""


def mixed(effect: Effect) -> Envelope:
    """Return the envelope of all tracks that are not muted, from 0 s to the end of the last one.

    The power of a mix is the sum of the tracks' powers, and its frequency their mean weighted by power, as
    `envelope_of` defines both. Where one track sounds, the mix is that track exactly. Transients at
    the same time become one of their sum. Raises `ParameterError` if nothing sounds.
    """
    tracks = [track for track in effect.tracks if not track.muted and track.gain > 0]
    seconds = max((track.end for track in tracks), default=0.0)
    if seconds == 0:
        raise ParameterError("nothing to play: add a ready effect, or draw on a track that is not muted")
    times = _times(tracks, seconds)
    power, turning = np.zeros(len(times)), np.zeros(len(times))
    weights = np.zeros(len(times))
    for track in tracks:
        own, hz, sounding = _lines(track, times)
        share = (track.gain * own) ** 2 + _OUTSIDE * sounding
        power += (track.gain * own) ** 2
        turning, weights = turning + share * hz, weights + share
    amplitude = np.sqrt(power)
    heard = weights > 0
    pulses = _pulses(tracks)
    if not pulses and not amplitude.any():
        raise ParameterError("nothing to play: every amplitude is 0; raise one")
    frequency_times, frequency = times[heard], turning[heard] / weights[heard]
    if not len(frequency_times):
        frequency_times, frequency = np.array([0.0]), np.array([tracks[0].frequency[0].value])
    return Envelope(seconds, times, amplitude, frequency_times, frequency, pulses)


def signal_of(effect: Effect) -> Signal:
    """Return the vibration of an effect, of unit 1; `ParameterError` if nothing sounds."""
    return carrier(mixed(effect))


def track_of(envelope: Envelope, title: str) -> Track:
    """Return a track close to an envelope within 0 to 1; `ParameterError` if it is longer than an effect can be."""
    if envelope.seconds > LONGEST_S:
        raise ParameterError(f"an effect lasts at most {LONGEST_S:g} s, got {envelope.seconds:g} s; cut it")
    if len(envelope.pulses) > MOST_TRANSIENTS:
        raise ParameterError(
            f"a track has at most {MOST_TRANSIENTS} transients, got {len(envelope.pulses)}; cut the file"
        )
    amplitude = _points(envelope.times, np.clip(envelope.amplitude, 0, 1), AMPLITUDE_STEP)
    # The frequency of silence, which files state, too, is no frequency.
    at = densified(np.union1d(envelope.times, envelope.frequency_times))
    heard = np.interp(at, envelope.times, envelope.amplitude, left=0.0, right=0.0) > 0
    at = at[heard] if heard.any() else envelope.frequency_times
    hz = np.interp(at, envelope.frequency_times, envelope.frequency)
    frequency = _points(at, np.clip(hz, LOWEST_HZ, HIGHEST_HZ), FREQUENCY_STEP_HZ)
    if np.ptp(hz) < FREQUENCY_STEP_HZ:
        frequency = frequency[:1]
    transients = tuple(
        Transient(
            time=round(pulse.time, DIGITS),
            amplitude=float(np.clip(pulse.amplitude, 0, 1)),
            frequency=float(np.clip(pulse.frequency, LOWEST_HZ, HIGHEST_HZ)),
        )
        for pulse in sorted(envelope.pulses, key=lambda pulse: pulse.time)
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
    envelope = envelope_of(one)
    fits = signal.unit == "1" and envelope.peak <= 1
    return track_of(envelope if fits or envelope.peak == 0 else envelope.scaled(1 / envelope.peak), title)


def _pulses(tracks: list[Track]) -> tuple[Pulse, ...]:
    """Return the transients in order; at the same time, amplitudes add up, and the frequency is their weighted mean."""
    by_time: dict[float, Pulse] = {}
    for track in tracks:
        for one in track.transients:
            added = track.gain * one.amplitude
            before = by_time.get(one.time, Pulse(one.time, 0.0, 0.0))
            amplitude = before.amplitude + added
            if amplitude > 0:
                hz = (before.amplitude * before.frequency + added * one.frequency) / amplitude
                by_time[one.time] = Pulse(one.time, amplitude, hz)
    return tuple(by_time[time] for time in sorted(by_time))


def _times(tracks: list[Track], seconds: float) -> NDArray[np.float64]:
    """Return the times between which the mix is a line: all points, edges, and a grid where tracks overlap."""
    times = [np.array([0.0, seconds])]
    spans = [(t.amplitude[0].time, t.amplitude[-1].time) for t in tracks if t.amplitude]
    for track in tracks:
        times.append(np.array([point.time for point in track.amplitude]))
        if track.amplitude:
            first, last = track.amplitude[0].time, track.amplitude[-1].time
            inside = [p.time for p in track.frequency if first <= p.time <= last]
            times.append(np.array([*inside, first - LEAST_S, last + LEAST_S]))
    starts = sorted(spans)
    reached = -1.0
    for first, last in starts:
        if first < reached:
            times.append(np.arange(first, min(reached, last), STEP_S))
        reached = max(reached, last)
    together = np.unique(np.round(np.concatenate(times), DIGITS))
    return together[(together >= 0) & (together <= seconds)]


def _lines(
    track: Track, times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Return amplitude and frequency (Hz) of a track at times, and whether they are within its amplitude's times."""
    hz = np.interp(times, [p.time for p in track.frequency], [p.value for p in track.frequency])
    if not track.amplitude:
        return np.zeros(len(times)), hz, np.zeros(len(times), bool)
    at = [p.time for p in track.amplitude]
    own = np.interp(times, at, [p.value for p in track.amplitude], left=0.0, right=0.0)
    return own, hz, (times >= at[0]) & (times <= at[-1])


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
    for i, (before, now) in enumerate(pairwise(at), 1):
        at[i] = round(max(now, before, at[i - 1] + LEAST_S), DIGITS)
    rounded = [round(float(values[i]), DIGITS) for i in chosen]
    return tuple(
        Point(time=time, value=value) for time, value in zip(at, rounded, strict=True) if time <= LONGEST_S
    )
