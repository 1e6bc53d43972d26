"""Editing of effects, as pure functions that return a new track or effect."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from itertools import pairwise
from typing import Literal

import numpy as np

from tactogram.errors import ParameterError
from tactogram.rendering import HIGHEST_HZ, effects, thinned
from tactogram_studio.effects.effect import (
    DIGITS,
    LEAST_S,
    LONGEST_S,
    LOWEST_HZ,
    Effect,
    Point,
    Track,
    Transient,
    mixed,
    track_of,
)

Line = Literal["amplitude", "frequency"]
RANGES: dict[str, tuple[float, float]] = {"amplitude": (0.0, 1.0), "frequency": (LOWEST_HZ, HIGHEST_HZ)}
MOST_REPEATS = 100
_DRAWN = 0.02
"""Share of the range by which a line may deviate from what was drawn by hand."""
_STRAIGHT = 1e-3
"""Share of the range from which a point counts as off the line between its neighbours."""


def with_point(track: Track, line: Line, time: float, value: float) -> tuple[Track, int]:
    """Return a track with another point and its index; a point closer than `LEAST_S` is replaced."""
    new = _point(line, time, value)
    others = [point for point in getattr(track, line) if abs(point.time - new.time) >= LEAST_S - 1e-9]
    points = sorted([*others, new], key=lambda point: point.time)
    return track.changed(**{line: tuple(points)}), points.index(new)


def moved_point(track: Track, line: Line, index: int, time: float, value: float) -> Track:
    """Return a track with a point elsewhere, at most as far as its neighbours."""
    points = list(getattr(track, line))
    _check_index(index, points, line)
    first = points[index - 1].time + LEAST_S if index else 0.0
    last = points[index + 1].time - LEAST_S if index + 1 < len(points) else LONGEST_S
    points[index] = _point(line, max(first, min(last, time)), value)
    return track.changed(**{line: tuple(points)})


def without_point(track: Track, line: Line, index: int) -> Track:
    """Return a track without a point; `ParameterError` for the only one of the frequency."""
    points = list(getattr(track, line))
    _check_index(index, points, line)
    if line == "frequency" and len(points) == 1:
        raise ParameterError("a track needs at least one point of the frequency; move it instead")
    return track.changed(**{line: (*points[:index], *points[index + 1 :])})


def drawn(track: Track, line: Line, points: Iterable[tuple[float, float]]) -> Track:
    """Return a track whose line follows a drawing, times (s) and values, from its first to its last time."""
    # Where the hand went back, the last value counts.
    by_step = {round(time / LEAST_S): value for time, value in points}
    new = tuple(
        _point(line, step * LEAST_S, by_step[step])
        for step in sorted(by_step)
        if 0 <= step * LEAST_S <= LONGEST_S
    )
    if not new:
        return track
    low, high = RANGES[line]
    outside = [point for point in getattr(track, line) if not new[0].time <= point.time <= new[-1].time]
    new = _thinned(new, _DRAWN * (high - low))
    return track.changed(**{line: _merged(outside, new)})


def value_at(points: tuple[Point, ...], time: float) -> float:
    """Return the value of a line at a time, s."""
    return _at(points, time).value


def with_transient(track: Track, time: float, amplitude: float, frequency: float) -> tuple[Track, int]:
    """Return a track with another transient, and its index."""
    new = _transient(time, amplitude, frequency)
    transients = sorted([*track.transients, new], key=lambda transient: transient.time)
    return track.changed(transients=tuple(transients)), transients.index(new)


def changed_transient(
    track: Track, index: int, *, time: float, amplitude: float, frequency: float
) -> tuple[Track, int]:
    """Return a track with a transient changed, and its index, which changes if it passes another."""
    return with_transient(without_transient(track, index), time, amplitude, frequency)


def without_transient(track: Track, index: int) -> Track:
    """Return a track without a transient."""
    _check_index(index, track.transients, "transients")
    return track.changed(transients=(*track.transients[:index], *track.transients[index + 1 :]))


def trimmed(track: Track, start: float, end: float) -> Track:
    """Return what a track has from ``start`` to ``end`` (s), where it is."""
    _check_range(start, end)
    return _part(track, start, end)


def cleared(track: Track, start: float, end: float) -> Track:
    """Return a track that is silent from ``start`` to ``end`` (s); the rest stays where it is."""
    _check_range(start, end)
    kept = _joined(_part(track, 0.0, start), _part(track, end, LONGEST_S))
    return track.changed(amplitude=kept.amplitude, transients=kept.transients)


def faded(track: Track, start: float, end: float, direction: Literal["in", "out"]) -> Track:
    """Return a track whose amplitude grows from 0 (``in``) or falls to 0 (``out``) from ``start`` to ``end`` (s)."""
    _check_range(start, end)

    def factor(time: float) -> float:
        share = (time - start) / (end - start)
        return share if direction == "in" else 1 - share

    inside = _cut(track.amplitude, start, end)
    points: tuple[Point, ...] = inside
    count = min(17, int((end - start) / LEAST_S / 2))
    for time in np.linspace(start, end, count + 2)[1:-1] if inside else ():
        if inside[0].time < time < inside[-1].time:
            points = _merged(points, [_at(inside, float(time))])
    scaled = [_point("amplitude", point.time, point.value * factor(point.time)) for point in points]
    outside = [point for point in track.amplitude if not start <= point.time <= end]
    transients = tuple(
        _transient(transient.time, transient.amplitude * factor(transient.time), transient.frequency)
        if start <= transient.time <= end
        else transient
        for transient in track.transients
    )
    return track.changed(amplitude=_straightened(_merged(outside, scaled), 1.0), transients=transients)


def repeated(track: Track, start: float, end: float, *, times: int, gap: float = 0.0) -> Track:
    """Return a track that plays ``start`` to ``end`` (s) so often, ``gap`` s apart; what follows is moved back."""
    _check_range(start, end)
    if not 1 <= times <= MOST_REPEATS:
        raise ParameterError.must("repeats", f"be 1 to {MOST_REPEATS}", times)
    if not 0 <= gap <= LONGEST_S:
        raise ParameterError(f"the gap must be 0 to {LONGEST_S:g} s, got {gap:g}")
    step = end - start + gap
    total = track.end + (times - 1) * step
    if total > LONGEST_S:
        raise ParameterError(f"an effect lasts at most {LONGEST_S:g} s, this would be {total:.3g} s")
    piece, result = _part(track, start, end), _part(track, 0.0, start)
    for number in range(times):
        result = _joined(result, shifted(piece, number * step))
    rest = _part(track, end, LONGEST_S)
    return _joined(result, shifted(rest, (times - 1) * step)) if rest.end else result


def shifted(track: Track, seconds: float) -> Track:
    """Return a track that plays later, or earlier, at the earliest at 0 s."""
    seconds = max(seconds, -track.start)
    last = max([track.end, *(point.time for point in track.amplitude)])
    if last + seconds > LONGEST_S:
        raise ParameterError(f"an effect lasts at most {LONGEST_S:g} s, this would be {last + seconds:.3g} s")

    def points(line: Iterable[Point]) -> tuple[Point, ...]:
        return tuple(
            Point(time=round(point.time + seconds, DIGITS), value=point.value)
            for point in line
            if 0 <= round(point.time + seconds, DIGITS) <= LONGEST_S
        )

    return track.changed(
        amplitude=points(track.amplitude),
        frequency=points(_cut(track.frequency, -seconds, LONGEST_S)) or (_at(track.frequency, -seconds),),
        transients=tuple(
            _transient(transient.time + seconds, transient.amplitude, transient.frequency)
            for transient in track.transients
        ),
    )


def merged(effect: Effect) -> Effect:
    """Return an effect whose tracks that are not muted are mixed into one, behind the muted ones."""
    events = mixed(effect)
    quieter = events if events.peak <= 1 else events.scaled(1 / events.peak)
    title = " + ".join(track.title for track in effect.tracks if not track.muted)
    mix = track_of(quieter, title)
    gain = min(2.0, max(1.0, events.peak))
    muted = tuple(track for track in effect.tracks if track.muted)
    return effect.changed(tracks=(*muted, mix.changed(gain=gain)))


def _point(line: str, time: float, value: float) -> Point:
    low, high = RANGES[line]
    return Point(time=_time(time), value=round(max(low, min(high, value)), DIGITS))


def _transient(time: float, amplitude: float, frequency: float) -> Transient:
    low, high = RANGES["frequency"]
    amplitude = round(max(0.0, min(1.0, amplitude)), DIGITS)
    return Transient(time=_time(time), amplitude=amplitude, frequency=max(low, min(high, frequency)))


def _time(time: float) -> float:
    return round(max(0.0, min(LONGEST_S, time)), DIGITS)


def _check_index(index: int, among: tuple[object, ...] | list[Point], name: str) -> None:
    if not 0 <= index < len(among):
        raise ParameterError(
            f"the track has {len(among)} points or transients of {name}, there is no {index + 1}."
        )


def _check_range(start: float, end: float) -> None:
    if not 0 <= start <= end - LEAST_S + 1e-9 <= LONGEST_S:
        raise ParameterError(
            f"the range must be within 0 to {LONGEST_S:g} s and its end after its start, got {start:g} to {end:g} s"
        )


def _part(track: Track, start: float, end: float) -> Track:
    """Return a track from ``start`` to ``end`` (s); silent if that is nothing."""
    return track.changed(
        amplitude=_cut(track.amplitude, start, end) if end > start else (),
        frequency=_cut(track.frequency, start, end) or (_at(track.frequency, start),),
        transients=tuple(transient for transient in track.transients if start <= transient.time < end),
    )


def _at(points: tuple[Point, ...], time: float) -> Point:
    value = np.interp(time, [point.time for point in points], [point.value for point in points])
    return Point(time=_time(time), value=round(float(value), DIGITS))


def _cut(points: tuple[Point, ...], start: float, end: float) -> tuple[Point, ...]:
    """Return the part of a line from ``start`` to ``end``, with points at its ends where the line has any."""
    if not points:
        return ()
    inside = [point for point in points if start <= point.time <= end]
    ends = [_at(points, time) for time in (start, end) if points[0].time < time < points[-1].time]
    return _merged(inside, ends)


def _merged(points: Iterable[Point], more: Iterable[Point]) -> tuple[Point, ...]:
    """Return points in order; of two closer than `LEAST_S`, the one of ``more``."""
    new = tuple(more)
    kept = [point for point in points if all(abs(point.time - other.time) >= LEAST_S - 1e-9 for other in new)]
    return tuple(sorted([*kept, *new], key=lambda point: point.time))


def _joined(first: Track, second: Track) -> Track:
    """Return a track of two that follow each other, silent between them."""
    return first.changed(
        amplitude=_followed(first.amplitude, second.amplitude, silent=True),
        frequency=_straightened(_followed(first.frequency, second.frequency, silent=False), HIGHEST_HZ),
        transients=(*first.transients, *second.transients),
    )


def _followed(first: tuple[Point, ...], second: tuple[Point, ...], *, silent: bool) -> tuple[Point, ...]:
    if not first or not second:
        return first or second
    end, start = first[-1], second[0]
    if start.time - end.time < LEAST_S - 1e-9:
        if abs(start.value - end.value) < 1e-6:
            return (*first, *(point for point in second[1:] if point.time - end.time >= LEAST_S - 1e-9))
        later = Point(time=round(end.time + LEAST_S, DIGITS), value=start.value)
        return (*first, later, *(p for p in second[1:] if p.time - later.time >= LEAST_S - 1e-9))
    room = round((start.time - end.time) / LEAST_S, 3)
    zeros = [end.time + LEAST_S] if end.value and room >= 2 else []
    zeros += [start.time - LEAST_S] if start.value and room >= 2 + len(zeros) else []
    between = [Point(time=round(time, DIGITS), value=0.0) for time in zeros] if silent else []
    return (*first, *between, *second)


def _thinned(points: tuple[Point, ...], tolerance: float) -> tuple[Point, ...]:
    times, values = (np.array([getattr(point, name) for point in points]) for name in ("time", "value"))
    return tuple(points[i] for i in thinned(times, values, tolerance))


def _straightened(points: tuple[Point, ...], span: float) -> tuple[Point, ...]:
    """Return a line without the points on the line between their neighbours."""
    kept = list(points[:1])
    for point, following in pairwise(points[1:]):
        line = np.interp(point.time, [kept[-1].time, following.time], [kept[-1].value, following.value])
        if abs(point.value - line) > _STRAIGHT * span:
            kept.append(point)
    if len(points) > 1:
        kept.append(points[-1])
    return tuple(kept[:1] if len({point.value for point in kept}) == 1 and span > 1 else kept)


@cache
def ready_track(name: str) -> Track:
    """Return one of `tactogram.effects` as a track that begins at 0 s."""
    ready = effects()[name]
    return track_of(ready.events(), ready.title)
